"""Libraries that run in a process of their own: those of another Python, and those that may crash."""
