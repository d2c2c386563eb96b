"""What the arm can carry at its flange."""
