"""Tasks of the arm, as weighted least-squares rows in the joint accelerations."""
