"""Friction problems of a single step, one file per kind, registered by a decorator (problems.catalogue)."""
