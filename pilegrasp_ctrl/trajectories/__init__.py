"""Trajectories of the tool frame: pose, twist and acceleration over time."""
