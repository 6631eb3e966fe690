"""Plans, runs, isolates, verifies and times; the command line."""
