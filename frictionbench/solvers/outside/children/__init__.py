"""Libraries that run in a process of their own, because they belong to another Python or may crash."""
