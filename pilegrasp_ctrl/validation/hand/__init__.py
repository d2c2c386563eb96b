"""Measurements of the hands on a bench and in an attempt."""
