"""Motion primitives, each of which ends by an event: approach, push, grasp, scoop, lift, move, carry, release."""
