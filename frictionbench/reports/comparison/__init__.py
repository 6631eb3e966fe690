"""The comparison of two runs as people and machines read it, and runs over time."""
