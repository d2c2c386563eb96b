"""Shovel on its force/torque sensor."""
