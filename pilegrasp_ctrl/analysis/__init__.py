"""Measures of a recording: motion, separation, force chains and held objects. They need numpy alone."""
