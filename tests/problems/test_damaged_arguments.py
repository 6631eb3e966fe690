"""Arguments that cannot be used raise InputError naming the argument, also where compiled code would read outside arrays."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import LCP, FrictionProblem, InputError
from frictionbench.problems.scenes import scene
from frictionbench.solvers import solve

START = np.arange(7, dtype=np.int32)


def damaged(form: str = "csr", **parts: object) -> sparse.csr_array:
    """The identity of order 6 with other arrays."""
    matrix = sparse.eye_array(6).asformat(form)
    for name, value in parts.items():
        setattr(matrix, name, value)
    return matrix


MATRICES = {
    "negative": damaged(indptr=np.array([0, -5, 2, 3, 4, 5, 6], np.int32)),
    "negative start": damaged(indptr=np.array([-3, 1, 2, 3, 4, 5, 6], np.int32)),
    "too long": damaged(indptr=np.append(START, START[-1])),
    "too short": damaged(indptr=START[:-1]),
    "empty": damaged(indptr=START[:0]),
    "overflowing": damaged(indptr=np.append(START[:-1], np.int32(-(2**31)))),  # its last difference is positive again
    "beyond the end": damaged(indptr=np.append(START[:-1], np.int32(10**6))),
    "large index": damaged(indices=START[:-1] + 100),
    "negative index": damaged(indices=START[:-1] - 100),
    "few entries": damaged(data=np.ones(1)),
    "columns": damaged("csc", indptr=START[:-1]),
    "triplets": damaged("coo", coords=(START[:-1] - 9, START[:-1])),
    "few triplets": damaged("coo", coords=(START[:1], START[:1])),
    "one axis": sparse.coo_array(np.ones(6)),
}


@pytest.mark.parametrize("matrix", MATRICES.values(), ids=MATRICES)
def test_damaged_sparse_matrices(matrix) -> None:
    mass = {
        "normal": np.ones((1, 6)),
        "tangent": np.ones((1, 6)),
        "friction": [0.5],
        "free_velocity": np.ones(6),
        "bias": [0.0],
    }
    with pytest.raises(InputError, match=r"^mass: "):
        FrictionProblem(mass=matrix, **mass)
    with pytest.raises(InputError, match=r"^M: "):
        LCP(matrix, np.ones(6))
    with pytest.raises(InputError, match=r"^W: "):
        FrictionProblem.from_delassus(matrix, np.ones(6), [0.5] * 3, 2)


@pytest.mark.parametrize("dimension", [2.0, None, "2", [2], 4, float("nan")])
def test_dimension(dimension) -> None:
    with pytest.raises(InputError, match=r"^d: must be 2 or 3"):
        FrictionProblem.from_delassus(np.eye(2), np.ones(2), [0.5], dimension)


@pytest.mark.parametrize("solver", [None, 5, ["lemke"], b"lemke", object(), "", "lemke[", "lemke[restarts=-1]"])
def test_names_of_solvers(solver) -> None:
    with pytest.raises(InputError, match=r"^solver: "):
        solve(scene("stack", blocks=1).problem(), solver)


@pytest.mark.parametrize("blocks", [2**70, -1, 2.5, None, "3"])
def test_blocks(blocks) -> None:
    with pytest.raises(InputError, match=r"blocks"):
        scene("stack", blocks=blocks)


def test_entries_that_overflow() -> None:
    for W in (np.full((4, 4), 1e308), np.eye(4) * 1e308, np.eye(4) * 1e200):
        with pytest.raises(InputError, match=r"^W: its entries must be below 1e\+150"):
            FrictionProblem.from_delassus(W, -np.ones(4), [0.5, 0.5], 2)
