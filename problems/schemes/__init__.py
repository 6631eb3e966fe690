"""One file a time-stepping scheme, one signature for all: see problems.schemes.stepping."""

from problems.schemes.anitescu_potra import anitescu_potra
from problems.schemes.stepping import Scheme, Solve, Solved, Step, start

SCHEMES: dict[str, Scheme] = {"anitescu_potra": anitescu_potra}

__all__ = ["SCHEMES", "Scheme", "Solve", "Solved", "Step", "anitescu_potra", "start"]
