"""What the compiled loops over packed problems share: which problems they take, where the impulses go, and what they return."""

from collections.abc import Sequence

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, kernel, lean
from frictionbench.problems.packed import CONTACT
from frictionbench.problems.rows import Index64
from frictionbench.solvers.balanced import UNLIKE
from frictionbench.solvers.interface import Solved, Status

ALONE = -1  # how a problem ends that is to be solved by itself


@kernel
def unsolved(packed, counts):  # type: ignore[no-untyped-def]
    """Impulses (contacts, d) of zeros, ALONE for each of the N problems, and its counts (N, counts), zeros."""
    count = len(packed.first) - 1
    contacts = packed.first[count, CONTACT] - packed.first[0, CONTACT]
    return np.zeros((contacts, packed.J.shape[1])), np.full(count, ALONE), np.zeros((count, counts), np.int64)


@lean
def is_alone(packed, k):  # type: ignore[no-untyped-def]
    """Whether problem k is to be solved by itself, because its islands have unlike speeds."""
    return packed.spread[k] > UNLIKE


@inlined
def impulses_of(packed, k, r):  # type: ignore[no-untyped-def]
    """Problem k's among the impulses of all (contacts, d), as a view."""
    begin = packed.first[0, CONTACT]
    return r[packed.first[k, CONTACT] - begin : packed.first[k + 1, CONTACT] - begin]


def solved(r: Array, ended: Index64, statuses: Sequence[Status], work: Index64, names: tuple[str, ...]) -> Solved:
    """The results of a loop: the status of each end but ALONE, and the counts (N, names)."""
    told = np.array([*statuses, None])
    return Solved(r, told[ended], dict(zip(names, work.T, strict=True)))
