"""solvers/portfolio/shares.py: what the members of `hybrid` bring, by which it divides a time limit among them.

    python -m frictionbench.commands.shares > solvers/portfolio/shares.py

The problems are the candidates of the suite `hard`, for each order of the members those for which hybrid takes it. The first
two members are run on all, each of the others on those that the ones before it did not solve, from zero impulses and for at
most LIMIT seconds. What has a residual within TOL, or within the floor of rounding where that is larger, is solved. Times are
the processor's, the least of ROUNDS, and only their ratios on one problem count.

A problem is brought by the member that needs the least limit with the fraction that it has: the one of least t_i/f_i. As f_i
follows from what is brought (solvers.hybrid), both are found in turn, from equal fractions, until they stay the same.
"""

import sys
from time import process_time

import numpy as np

from frictionbench.harness.plans.hard import families
from frictionbench.harness.plans.named import problem_of
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.residual import residual_with_floor
from frictionbench.solvers import solve
from frictionbench.solvers.hybrid import PLANAR, SPATIAL, SWEEPS, in_order, simple_first
from frictionbench.solvers.interface import dense_storage, find

TOL, LIMIT, ROUNDS, STORAGE = 1e-8, 2.0, 3, 2**31
HEAD = '''"""How many problems each member of `hybrid` brings, by the contacts' dimension and the first member.

Made by `python -m frictionbench.commands.shares`, which says how.
"""

BROUGHT: dict[tuple[int, str], dict[str, int]] = {'''


def table() -> str:
    """The module in Python."""
    lines = [HEAD]
    for dimension, members in ((2, PLANAR), (3, SPATIAL)):
        problems = [problem_of(source.scene, source.parameters) for family in families(dimension).values() for source in family]
        seconds = _seconds(members, problems)
        simple = np.array([simple_first(problem) for problem in problems])
        for first in (True, False):
            order, own = in_order(members, first), seconds[:, simple == first]
            counts = brought(own[[members.index(member) for member in order]])
            lines.append(f'    ({dimension}, "{order[0]}"): {{')
            lines += [f'        "{member}": {count},' for member, count in zip(order, counts, strict=True)]
            lines.append("    },")
    return "\n".join([*lines, "}\n"])


def brought(seconds: Array) -> list[int]:
    """The problems that each member brings, of its times (members, problems), infinity where it does not solve one."""
    times = seconds[:, np.isfinite(seconds).any(axis=0)]
    counts = np.zeros(len(times), np.int64)
    while True:
        before, counts = counts, np.bincount(np.argmin(times / (counts + 1)[:, None], axis=0), minlength=len(times))
        if (counts == before).all():
            return [int(count) for count in counts]


def _seconds(members: tuple[str, ...], problems: list[FrictionProblem]) -> Array:
    """The times (members, problems), s; infinity where a problem is not solved."""
    seconds = np.full((len(members), len(problems)), np.inf)
    for k, member in enumerate(members):
        for i, problem in enumerate(problems):
            if k < 2 or np.isinf(seconds[:k, i]).all():
                seconds[k, i] = time_of(member, problem)
    return seconds


def time_of(member: str, problem: FrictionProblem) -> float:
    info, instance = find(member)
    if info.refuses(problem) or dense_storage(instance, problem) > STORAGE:
        return float("inf")
    least = float("inf")
    for _ in range(1 + ROUNDS):  # the first compiles and loads
        given = problem.fresh()
        begun = process_time()
        answer = solve(given, member, tol=TOL, limit=SWEEPS if member == "nsgs" else None, time_limit=LIMIT)
        took = process_time() - begun
        found, floor = residual_with_floor(problem, answer.impulse)
        if not found <= max(TOL, floor):
            return float("inf")
        least = min(least, took)
    return least


if __name__ == "__main__":
    sys.stdout.write(table())
