"""Running tasks in isolated worker processes, on this machine or a cluster."""
