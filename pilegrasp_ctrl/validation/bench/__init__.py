"""The benchmark: what a control period costs, beside others, and in the closed loop."""
