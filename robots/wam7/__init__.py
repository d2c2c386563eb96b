"""Barrett WAM with seven degrees of freedom."""
