"""The arm as the controllers see it: its model, its state at one instant, and its friction."""
