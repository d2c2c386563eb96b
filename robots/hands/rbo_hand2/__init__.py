"""RBO Hand 2 on its force/torque sensor."""
