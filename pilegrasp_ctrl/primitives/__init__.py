"""Motion primitives of the grasp strategy: approach, push, grasp and lift, each ended by an event."""
