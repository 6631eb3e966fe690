"""What cannot be used is refused with the name of its field, in problems, answers and parameters.

That is what is no finite real number, and sparse matrices whose arrays do not fit, outside which compiled code would read.
"""

from fractions import Fraction

import numpy as np
import pytest
from scipy import sparse

import frictionbench as fb
from frictionbench.problems import LCP, FrictionProblem, InputError
from frictionbench.problems.check import number

GOOD = {
    "mass": np.diag([2.0, 3.0]),
    "normal": np.array([[0.0, 1.0]]),
    "tangent": np.array([[1.0, 0.0]]),
    "friction": np.array([0.5]),
    "free_velocity": np.array([1.0, -0.1]),
    "bias": np.array([0.0]),
    "friction_bias": np.array([0.0]),
    "joints": np.zeros((1, 2)),
    "joint_bias": np.array([0.0]),
}
UNREAL = {
    "complex": lambda x: x + 1j,
    "masked": lambda x: np.ma.masked_array(x, mask=True),
    "text": lambda x: x.astype(str),
    "truth values": lambda x: x != 0,
    "objects": lambda x: np.array([Fraction(1, 2)] * x.size, dtype=object).reshape(x.shape),
    "dates": lambda x: x.astype("datetime64[s]"),
    "infinite": lambda x: x + np.inf,
    "not a number": lambda x: x * np.nan,
}


@pytest.mark.parametrize("kind", UNREAL)
@pytest.mark.parametrize("field", GOOD)
def test_field_of_a_problem(field, kind) -> None:
    FrictionProblem(**GOOD)
    with pytest.raises(InputError, match=f"^{field}: "):
        FrictionProblem(**GOOD | {field: UNREAL[kind](GOOD[field])})


MISFITS = {
    "mass": [np.eye(3), np.ones((2, 2)), -np.eye(2), [[1, 0.5], [0, 1]], np.diag([1.0, 0.0])],
    "normal": [[[0.0, 1.0, 0.0]], np.zeros((2, 2)), [0.0, 1.0]],
    "tangent": [[[1.0, 0.0, 0.0]], np.zeros((2, 2))],
    "friction": [[-0.1], 0.5, [0.5, 0.5]],
    "free_velocity": [[[1.0, 0.0]], [1.0, 2.0, 3.0]],
    "bias": [[0.0, 0.0]],
    "friction_bias": [[-1.0], [0.0, 0.0]],
    "joints": [[[1.0, 0.0, 0.0]]],
    "joint_bias": [[1.0, 0.0, 0.0]],
    "dimension": [1, 4, "2"],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in MISFITS.items() for value in values])
def test_a_field_that_does_not_fit(name, value) -> None:
    with pytest.raises(InputError, match=rf"^{name}: "):
        FrictionProblem(**GOOD | {name: value})


@pytest.mark.parametrize("kind", UNREAL)
def test_fields_of_other_forms(kind) -> None:
    W, q, mu, unreal = np.eye(2), np.array([-1.0, 1.0]), np.array([0.5]), UNREAL[kind]
    for name, fields in {"W": (unreal(W), q, mu), "q": (W, unreal(q), mu), "friction": (W, q, unreal(mu))}.items():
        with pytest.raises(InputError, match=f"^{name}: "):
            FrictionProblem.from_delassus(*fields, 2)
    for name, fields in {"M": (unreal(W), q), "q": (W, unreal(q))}.items():
        with pytest.raises(InputError, match=f"^{name}: "):
            LCP(*fields)


@pytest.mark.parametrize("make", [np.array, sparse.csr_array, sparse.csc_array, sparse.coo_array])
def test_the_entry_that_is_not_finite_is_named(make) -> None:
    mass = np.array([[2.0, 0.5, 0.0], [0.5, np.nan, 0.0], [0.0, 0.0, np.inf]])
    with pytest.raises(InputError, match=r"^M: entry \(1, 1\) is nan; all must be finite"):
        LCP(make(mass), np.ones(3))
    with pytest.raises(InputError, match=r"^q: entry 2 is -inf; all must be finite"):
        LCP(make(np.eye(3)), [0.0, 1.0, -np.inf])


def test_sparse_vector() -> None:
    with pytest.raises(InputError, match=r"^free_velocity: is sparse"):
        FrictionProblem(**GOOD | {"free_velocity": sparse.coo_array(GOOD["free_velocity"][None])})


@pytest.mark.parametrize("kind", [kind for kind in UNREAL if kind not in ("infinite", "not a number")])
def test_impulses(kind) -> None:
    problem, impulse = FrictionProblem(**GOOD), UNREAL[kind](np.array([[0.2, -0.1]]))
    for measure in (problem.velocity, problem.contact_velocity, problem.velocity_size):
        with pytest.raises(InputError, match=r"^impulse: "):
            measure(impulse)
    with pytest.raises(InputError, match=r"^start: "):
        fb.solve(problem, "nsgs", start=impulse)
    with pytest.raises(InputError, match=r"^z: "):
        problem.lcp().residual(UNREAL[kind](np.zeros(4)))


@pytest.mark.parametrize("value", [1j, np.complex128(1), True, "1", np.datetime64("2026-01-01"), np.nan, np.inf, [1.0]])
def test_parameters(value) -> None:
    with pytest.raises(InputError, match=r"^friction: "):
        number("friction", value, least=0.0)


def test_numbers_of_all_kinds_are_read() -> None:
    problem = FrictionProblem(**GOOD)
    for kind in (np.int64, np.uint8, np.float32, np.longdouble):
        whole = {"mass": np.diag([2, 3]).astype(kind), "normal": GOOD["normal"].astype(kind).tolist()}
        assert FrictionProblem(**GOOD | whole).hash == problem.hash


START = np.arange(7, dtype=np.int32)


def damaged(form: str = "csr", **parts: object) -> sparse.csr_array:
    """The identity of order 6 with other arrays."""
    matrix = sparse.eye_array(6).asformat(form)
    for name, value in parts.items():
        setattr(matrix, name, value)
    return matrix


MATRICES = {
    "negative": damaged(indptr=np.array([0, -5, 2, 3, 4, 5, 6], np.int32)),
    "too long": damaged(indptr=np.append(START, START[-1])),
    "empty": damaged(indptr=START[:0]),
    "overflowing": damaged(indptr=np.append(START[:-1], np.int32(-(2**31)))),  # its last difference is positive again
    "beyond the end": damaged(indptr=np.append(START[:-1], np.int32(10**6))),
    "negative index": damaged(indices=START[:-1] - 100),
    "few entries": damaged(data=np.ones(1)),
    "columns": damaged("csc", indptr=START[:-1]),
    "triplets": damaged("coo", coords=(START[:-1] - 9, START[:-1])),
    "one axis": sparse.coo_array(np.ones(6)),
}


@pytest.mark.parametrize("matrix", MATRICES.values(), ids=MATRICES)
def test_damaged_sparse_matrices(matrix) -> None:
    wide = {"normal": np.ones((1, 6)), "tangent": np.ones((1, 6)), "free_velocity": np.ones(6), "joints": np.zeros((1, 6))}
    with pytest.raises(InputError, match=r"^mass: "):
        FrictionProblem(**GOOD | wide | {"mass": matrix})
    with pytest.raises(InputError, match=r"^M: "):
        LCP(matrix, np.ones(6))
    with pytest.raises(InputError, match=r"^W: "):
        FrictionProblem.from_delassus(matrix, np.ones(6), [0.5] * 3, 2)


def test_entries_that_overflow() -> None:
    for W in (np.full((4, 4), 1e308), np.eye(4) * 1e308, np.eye(4) * 1e200, np.eye(4) * 1e-310):
        with pytest.raises(InputError, match=r"^W: its largest entry must be 0 or from 1e-150 to 1e\+150"):
            FrictionProblem.from_delassus(W, -np.ones(4), [0.5, 0.5], 2)
    with pytest.raises(InputError, match=r"^friction_bias: must be below 1e\+150"):
        FrictionProblem.from_delassus(np.eye(4), -np.ones(4), [0.5, 0.5], 2, [0.0, 1e155])
