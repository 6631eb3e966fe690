"""Whether Lemke's method is likely to be faster than an interior point on a planar problem, told before either runs.

The time of an interior point grows with the number of contacts, that of a pivot with the square of the active ones, and the
number of pivots is not known beforehand: one a contact in stacks that stick, two to five where contacts slide or open. In
stacks, pyramids, arches, discs, cards and random problems (tests/benchmarks/test_hybrid.py) the two methods take the same
time near 36 contacts in most families, and near 70 in chains of bodies of which few slip in the free motion. Arches are such
chains, too, but take many pivots; nothing cheap was found that tells them apart.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.compiled import kernel, loop
from frictionbench.problems.packed import CONTACT, Q, mechanical, mechanics_of

ALWAYS, CHAINS = 36, 64  # contacts up to which pivots are faster, in general and in chains
LINKS = 4  # contacts of a body in a chain: two with each neighbour
STICKING = 0.75  # of the contacts in a chain
AT_REST = 1e-6  # speeds below, relative to the fastest, are rounding


def few_pivots(problem: FrictionProblem) -> bool:
    """Whether Lemke's method should come before an interior point."""
    nc = problem.contacts
    if nc <= ALWAYS or nc > CHAINS or not problem.mechanical or len(problem.joint_bias):
        return nc <= ALWAYS
    return bool(sticking_chain(problem.contact_rows.column, problem.q, len(problem.free_velocity)))


@loop
def few_pivots_each(packed):  # type: ignore[no-untyped-def]
    """The same (N,) for planar packed problems, which have no joints."""
    few = np.empty(len(packed.first) - 1, np.bool_)
    for k in range(len(few)):
        nc = packed.first[k + 1, CONTACT] - packed.first[k, CONTACT]
        few[k] = nc <= ALWAYS
        if ALWAYS < nc <= CHAINS and mechanical(packed, k):
            _, column, _, _, _, _, free, _ = mechanics_of(packed, k)
            few[k] = sticking_chain(column, packed.q[packed.first[k, Q] : packed.first[k + 1, Q]], len(free))
    return few


@kernel
def sticking_chain(column, q, nv):  # type: ignore[no-untyped-def]
    """Whether no body has more than LINKS contacts and most contacts of the free motion q (2 nc,) do not slip.

    column: the velocities (nv of them) that act at the contacts, each contact's after the other's.
    """
    contacts = np.zeros(nv, np.int64)
    for v in column:
        contacts[v] += 1
        if contacts[v] > LINKS:
            return False
    fastest = 0.0
    for i in range(len(q)):
        fastest = max(fastest, abs(q[i]))
    slipping = 0
    for i in range(1, len(q), 2):
        slipping += abs(q[i]) > AT_REST * fastest
    return slipping <= (1 - STICKING) * (len(q) // 2)
