"""Motion primitives, each of which ends by an event: approach, push, grasp, lift, move, carry and release."""
