"""Plans, runs, isolates, verifies and times."""
