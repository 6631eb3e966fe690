"""What a run is to do: plans, suites, and how the command line chooses among them."""
