"""Measurements on the models of an attempt, each against a number that comes from elsewhere."""
