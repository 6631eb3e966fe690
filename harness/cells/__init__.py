"""What happens inside a worker: problems collected, cells solved and driven, rows written."""
