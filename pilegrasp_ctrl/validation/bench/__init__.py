"""The benchmark: the time of a control period, beside other libraries and in the closed loop."""
