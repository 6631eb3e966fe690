"""Plans of runs: suites, and how the command line chooses and changes them."""
