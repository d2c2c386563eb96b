"""Limits of the arm, as bounds on the joint accelerations and torques of one control period."""
