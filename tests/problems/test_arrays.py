"""The plain arrays of W and q are those of the sparse matrix, in the plane, in space, with joints and known by W alone."""

import ctypes

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.instances import make_instance
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.scenes import scene

PLANAR = random_problem(3, contacts=6)
PROBLEMS = {
    "plane": PLANAR,
    "space": make_instance("random_bodies", contacts=5),
    "joints": scene("slider_crank").problem(),
    "matrix": FrictionProblem.from_delassus(PLANAR.W, PLANAR.q, PLANAR.friction, 2),
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


def test_arrays_have_an_address() -> None:
    W, _ = PLANAR.dense()
    again = np.ctypeslib.as_array(W.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), W.shape)
    assert again[1, 0] == PLANAR.W[1, 0]
