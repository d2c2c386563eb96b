"""Programs of an attempt: grasp, push, line, or an order of several objects."""
