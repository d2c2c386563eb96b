"""Parallel-jaw gripper on its force/torque sensor."""
