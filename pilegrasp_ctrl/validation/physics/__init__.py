"""Measurements on the models of an attempt, each compared with a formula, a setting or a publication."""
