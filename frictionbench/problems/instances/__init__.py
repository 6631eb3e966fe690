"""Friction problems of one step, one file per kind, registered by a decorator (problems.catalogue)."""
