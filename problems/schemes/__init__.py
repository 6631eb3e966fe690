"""One file a time-stepping scheme, one signature for all: see problems.schemes.stepping."""

from problems.schemes.acceleration import acceleration
from problems.schemes.anitescu_potra import anitescu_potra
from problems.schemes.lotstedt import lotstedt
from problems.schemes.moreau import moreau, moreau_euler
from problems.schemes.paoli_schatzman import paoli_schatzman
from problems.schemes.stepping import NoSolution, Scheme, Solve, Solved, Step, start
from problems.schemes.stewart_trinkle import stewart_trinkle

SCHEMES: dict[str, Scheme] = {
    "acceleration": acceleration,
    "anitescu_potra": anitescu_potra,
    "lotstedt": lotstedt,
    "moreau": moreau,
    "moreau_euler": moreau_euler,
    "paoli_schatzman": paoli_schatzman,
    "stewart_trinkle": stewart_trinkle,
}

__all__ = ["SCHEMES", "NoSolution", "Scheme", "Solve", "Solved", "Step", "anitescu_potra", "start"]
