"""One file a method or outside library, one signature for all: see solvers.interface."""

from solvers.interface import Answer, Solver, SolverInfo, Status, available, find, solve, solver

__all__ = ["Answer", "Solver", "SolverInfo", "Status", "available", "find", "solve", "solver"]
