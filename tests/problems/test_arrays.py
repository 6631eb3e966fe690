"""The plain arrays of W and q, in the plane, in space, with joints and known by W alone.

They are those of the sparse matrix, and those of copies of the same kinds, so that no kernel is compiled again.
"""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import make_instance
from frictionbench.problems.copies import duplicate, nudged
from frictionbench.problems.forms import delassus
from frictionbench.problems.instances.random_bodies import random_problem
from tests.helpers.friction_problems import known_by_W

PLANAR = random_problem(3, contacts=6)
PROBLEMS = {
    "plane": PLANAR,
    "space": make_instance("random_bodies", contacts=5),
    "joints": make_instance("rod_chain", links=3),
    "matrix": known_by_W(PLANAR),
    "nothing": FrictionProblem.from_delassus(np.zeros((0, 0)), [], [], 3),
}


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS)
def test_arrays_are_those_of_W(problem: FrictionProblem) -> None:
    n = problem.contacts * problem.dimension
    W, q = problem.dense()
    indptr, indices, data, same = problem.csr()
    assert np.array_equal(W, problem.W.toarray())
    assert np.array_equal(W, sparse.csr_array((data, indices, indptr), shape=(n, n)).toarray())
    assert q is same is problem.q
    for array in (W, q, indptr, indices, data):
        assert array.flags.c_contiguous
        assert not array.flags.writeable
    assert problem.dense().W is W
    assert problem.fresh().dense().W is not W


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS)
def test_no_kernel_is_compiled_for_a_copy(problem: FrictionProblem) -> None:
    kernels = delassus.delassus, delassus.array_of_blocks, delassus.measures, delassus.velocity, delassus.contact_velocity
    _use(problem.fresh())
    compiled = [len(kernel.signatures) for kernel in kernels]
    for same in (duplicate(problem), nudged(problem, 1), problem.balanced()[0], duplicate(problem.balanced()[0])):
        _use(same)
    assert [len(kernel.signatures) for kernel in kernels] == compiled


def _use(problem: FrictionProblem) -> None:
    """What methods ask of a problem."""
    problem.dense(), problem.csr(), problem.units
    problem.contact_velocity(0 * problem.offset)
