"""Dense arrays of a user: what is read, and errors that name the array that was given."""

import re

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.recorded import native, read
from frictionbench.problems.recorded.archive import require_known
from tests.helpers.friction_problems import known_by_W

# Two contacts in space of one body: six velocities; one joint equation.
J = np.random.default_rng(1).standard_normal((6, 6))
BODIES = {
    "M": np.diag([2.0, 2.0, 2.0, 0.1, 0.2, 0.3]),
    "N": J[:2],
    "T": J[2:],
    "mu": np.array([0.5, 0.6]),
    "v": np.arange(6.0) / 10,
    "b": np.array([0.1, -0.1]),
    "fb": np.array([0.0, 0.2]),
    "F": np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]]),
    "bF": np.array([0.05]),
    "d": np.array(3),
}
DELASSUS = {"W": J @ J.T, "q": np.arange(6.0), "mu": np.array([0.5, 0.6]), "d": np.array(3), "fb": np.array([0.0, 0.1])}
LCP = {"M": np.eye(3), "q": -np.ones(3)}
CONTACTBENCH = {"G": J @ J.T, "g": np.ones((6, 1)), "mus": np.array([0.5, 0.6])}
PAIRS = {"F", "bF"}, {"M", "q"}  # of which none can say which of the two is wrong
FORMS = {"bodies": BODIES, "delassus": DELASSUS, "lcp": LCP, "contactbench": CONTACTBENCH}


def written(tmp_path, arrays):
    path = tmp_path / "problem.npz"
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})
    return path


def complaint(tmp_path, arrays) -> str:
    with pytest.raises(InputError) as error:
        read(written(tmp_path, arrays))
    return str(error.value).partition("problem.npz: ")[2]


def test_every_array_is_read(tmp_path) -> None:
    given = {"mass": "M", "normal": "N", "tangent": "T", "friction": "mu", "free_velocity": "v"}
    given |= {"bias": "b", "friction_bias": "fb", "joints": "F", "joint_bias": "bF"}
    problem = read(written(tmp_path, BODIES))
    assert problem.hash == FrictionProblem(dimension=3, **{field: BODIES[name] for field, name in given.items()}).hash
    assert read(written(tmp_path, DELASSUS)).friction_bias.tolist() == [0.0, 0.1]


def test_unknown_arrays_of_our_own_format_are_refused(tmp_path) -> None:
    problem = fb.scene("stack", blocks=1).problem()
    for one in (problem, known_by_W(problem), problem.lcp()):
        native.save(one, tmp_path / "problem.npz")
        with np.load(tmp_path / "problem.npz") as stored:
            arrays = dict(stored)
        assert complaint(tmp_path, arrays | {"J_data": np.ones(2)}).startswith("J_data: unknown array")
    assert complaint(tmp_path, arrays | {"dimension": np.array(2.5)}).startswith("dimension: must be 2 or 3")


def test_found_answers_may_stand_beside(tmp_path) -> None:
    beside = BODIES | {"r": np.zeros(6), "u_siconos": np.zeros(6)}
    assert read(written(tmp_path, beside)).hash == read(written(tmp_path, BODIES)).hash
    with pytest.raises(InputError, match=r"^radius: unknown array"):
        require_known(["radius"], ["M"])


def test_unknown_and_missing_arrays_are_named(tmp_path) -> None:
    for arrays, name in ((BODIES, "Mu"), (LCP, "mu"), (CONTACTBENCH, "mu")):
        assert complaint(tmp_path, arrays | {name: np.ones(2)}).startswith(f"{name}: unknown array; known are ")
    for arrays, names in ((BODIES, ("M", "N", "T", "mu", "v")), (DELASSUS, ("q", "mu", "d"))):
        for missing in names:
            assert complaint(tmp_path, arrays | {missing: None}) == f"{missing}: missing"


@pytest.mark.parametrize("form", FORMS)
def test_wrong_sizes_are_blamed_on_the_array_that_has_them(tmp_path, form) -> None:
    """Each array with a row too many or too few, or with a column too many."""
    for name, value in FORMS[form].items():
        wrong = [value[:-1], np.concatenate([value, value[:1]])] if value.ndim else []
        wrong += [np.hstack([value, value[:, :1]])] if value.ndim == 2 and name != "g" else []
        for array in wrong:
            told = complaint(tmp_path, FORMS[form] | {name: array})
            assert re.match(r"\w+", told)[0] in next((pair for pair in PAIRS if name in pair), {name}), told


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("spoil", [lambda x: x + 1j, lambda x: x * np.nan], ids=["complex", "not a number"])
def test_what_is_no_number_is_blamed_on_its_array(tmp_path, form, spoil) -> None:
    for name, value in FORMS[form].items():
        assert complaint(tmp_path, FORMS[form] | {name: spoil(np.where(value == 0, 1.0, value))}).startswith(f"{name}: ")


def test_values_are_blamed_on_their_array(tmp_path) -> None:
    assert complaint(tmp_path, BODIES | {"mu": np.array(-0.5)}) == "mu: must not be negative"
    assert complaint(tmp_path, BODIES | {"fb": -np.ones(2)}) == "fb: must not be negative"
    assert complaint(tmp_path, BODIES | {"M": np.triu(np.ones((6, 6)))}).startswith("M: not ")
    assert complaint(tmp_path, CONTACTBENCH | {"mus": -np.ones(2)}) == "mus: must not be negative"
    eight = {"W": np.eye(8), "q": np.ones(8), "mu": 0.5, "d": 3}
    assert complaint(tmp_path, eight) == "W: states no whole number of contacts by its shape (8, 8); d is 3"
    assert complaint(tmp_path, BODIES | {"d": None}).endswith("; d, which is left out, is 2")
    for d in (np.array(7), np.array([2, 3]), np.array("2")):
        assert complaint(tmp_path, DELASSUS | {"d": d}).startswith("d: ")
    assert complaint(tmp_path, BODIES | {"vfree": BODIES["v"]}).startswith("vfree: another name of v")


@pytest.mark.parametrize("columns", [False, True])
def test_velocities_of_another_number_are_blamed_on_their_array(tmp_path, columns) -> None:
    """Also where it is that of the contacts, by which N and T could be taken to have these in columns."""
    plane = {"M": np.eye(3), "N": np.eye(3)[:2], "T": np.eye(3)[1:], "mu": np.full(2, 0.5), "b": np.zeros(2)}
    plane |= {"N": plane["N"].T, "T": plane["T"].T} if columns else {}
    for size in (1, 2, 4):
        told = f"v: states {size} velocities by its shape ({size},), but N, T, M 3"
        assert complaint(tmp_path, plane | {"v": np.ones(size)}) == told
    assert complaint(tmp_path, plane | {"v": np.ones((3, 1))}) == "v: expected a vector, got shape (3, 1)"


def test_contacts_in_columns(tmp_path) -> None:
    rows = read(written(tmp_path, BODIES))
    assert read(written(tmp_path, BODIES | {"N": BODIES["N"].T, "T": BODIES["T"].T})).hash == rows.hash
    assert complaint(tmp_path, BODIES | {"N": BODIES["N"].T}) == "N: has its contacts in columns, and T in rows"
    assert complaint(tmp_path, BODIES | {"T": BODIES["T"].T}) == "T: has its contacts in columns, and N in rows"
    assert complaint(tmp_path, BODIES | {"N": BODIES["N"][0]}).startswith("N: expected a matrix")


def test_square_matrices_are_read_by_rows_unless_the_other_says_columns(tmp_path) -> None:
    N, T = np.random.default_rng(2).standard_normal((2, 3, 3))
    plane = {"M": np.eye(3), "N": N, "T": T, "mu": np.array(0.5), "v": np.ones(3)}
    assert np.array_equal(read(written(tmp_path, plane)).normal.toarray(), N)
    wide = np.random.default_rng(2).standard_normal((6, 3))
    space = plane | {"T": wide.T, "d": np.array(3)}
    assert np.array_equal(read(written(tmp_path, space)).normal.toarray(), N.T)


def test_W_beside_bodies_is_compared_with_theirs(tmp_path) -> None:
    problem = read(written(tmp_path, BODIES))
    W, q = problem.W.toarray(), problem.q
    assert read(written(tmp_path, BODIES | {"W": W.round(9), "q": q.round(9)})).hash == problem.hash
    assert "W: differs from that of the bodies by up to 0.1" in complaint(tmp_path, BODIES | {"W": W + 0.1 * np.eye(6)})
    assert complaint(tmp_path, BODIES | {"q": q[:-1]}).startswith("q: expected shape (6,)")
    n = 20_000  # contacts, all of one body: their W would not fit into any memory
    many = {"N": np.ones((n, 1)), "T": np.ones((n, 1)), "mu": np.array(0.5), "M": np.eye(1), "v": np.ones(1)}
    assert complaint(tmp_path, many | {"W": np.eye(2)}).startswith(f"W: expected shape {(2 * n, 2 * n)}")
