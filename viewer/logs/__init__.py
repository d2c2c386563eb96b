"""Recordings for other programs: Rerun, Foxglove, and tables of the signals."""
