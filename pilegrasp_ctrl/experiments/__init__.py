"""Experiments without a physics engine: tracking, step and frequency responses of any arm."""
