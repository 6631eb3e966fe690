"""The scaled LCP of a packed problem, for the loops of the pivoting methods, and what these loops return."""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined
from frictionbench.problems.packed import Q, blocks_of, law_of
from frictionbench.problems.rows import Index64
from frictionbench.solvers.interface import Solved
from frictionbench.solvers.pivots.inverse_basis import Matrix
from frictionbench.solvers.pivots.scaled_lcp import STATUS, scaled_friction_lcp

ALONE = -1  # how a problem ends that is to be solved by itself, because its islands have unlike speeds
_STATUS = np.array([STATUS[ended] for ended in range(len(STATUS))] + [None])


@inlined
def scaled_lcp_of(packed, k, basis):  # type: ignore[no-untyped-def]
    """Problem k's scaled LCP: stretch, M, q and unit as in ScaledLCP."""
    first, neighbours, block = blocks_of(packed, k)
    mu, wider, scale, units = law_of(packed, k)
    q = packed.q[packed.first[k, Q] : packed.first[k + 1, Q]]
    start, rows, column, row, stretch, right, unit = scaled_friction_lcp(
        first, neighbours, block, q, mu, wider, basis, scale, units
    )
    return stretch, Matrix(start, rows, column, row), right, unit


def counted(impulse: Array, ended: Index64, work: Index64, names: tuple[str, ...]) -> Solved:
    """The results of a loop, with the counts work (N, names)."""
    return Solved(impulse, _STATUS[ended], dict(zip(names, work.T, strict=True)))
