"""What the arm is asked to do, as weighted least-squares rows in the joint accelerations."""
