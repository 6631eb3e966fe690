"""Output of the comparison of two runs, for people and programs, and of runs over time."""
