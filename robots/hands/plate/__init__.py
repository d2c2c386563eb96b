"""Flat plate on its force/torque sensor."""
