"""Pivoting for linear complementarity problems: scaling, bases and their updates, and paths of pivots."""
