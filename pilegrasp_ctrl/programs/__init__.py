"""What an attempt consists of: grasp, push, line, or an order of several objects."""
