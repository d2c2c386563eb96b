"""The quadratic program of one control period: the program, its answer, and the solvers."""
