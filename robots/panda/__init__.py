"""Franka Emika Panda with seven degrees of freedom."""
