"""Solvers, one file per method, with a common interface; a decorator registers them (solvers.interface)."""

from frictionbench.problems.catalogue import import_all
from frictionbench.solvers import outside
from frictionbench.solvers.interface import Answer, Solver, SolverInfo, Status, available, find, solve, solver
from frictionbench.solvers.interior.phases import one_start
from frictionbench.solvers.many import Answers, solve_many

import_all(__name__, __path__)
import_all(outside.__name__, outside.__path__)

__all__ = [
    "Answer",
    "Answers",
    "Solver",
    "SolverInfo",
    "Status",
    "available",
    "find",
    "one_start",
    "solve",
    "solve_many",
    "solver",
]
