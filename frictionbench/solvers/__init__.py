"""Solvers, one file per method, with a common interface; a decorator registers them (solvers.interface)."""

from frictionbench.problems.catalogue import import_all
from frictionbench.solvers import outside
from frictionbench.solvers.interface import (
    Answer as Answer,
    Solver as Solver,
    SolverInfo as SolverInfo,
    Status as Status,
    available as available,
    find as find,
    solve as solve,
    solver as solver,
)
from frictionbench.solvers.interior.phases import one_start as one_start
from frictionbench.solvers.many import Answers as Answers, solve_many as solve_many

import_all(__name__, __path__)
import_all(outside.__name__, outside.__path__)
