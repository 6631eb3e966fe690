"""Libraries that run in a process of their own: another Python's, or such as may crash."""
