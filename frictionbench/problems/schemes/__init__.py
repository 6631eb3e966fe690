"""Time-stepping schemes: one file each, with a common signature, registered by a decorator (problems.schemes.stepping)."""

from frictionbench.problems.catalogue import import_all
from frictionbench.problems.schemes.stepping import SCHEMES, NoSolution, Scheme, Solve, Solved, Step, require_scheme, start

import_all(__name__, __path__)

__all__ = ["SCHEMES", "NoSolution", "Scheme", "Solve", "Solved", "Step", "require_scheme", "start"]
