"""What happens inside a worker: problems collected, cells solved and simulated, rows written."""
