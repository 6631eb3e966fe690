"""Limit, tolerance, start and impulses are validated before compiled code runs, with errors that name the field."""

import subprocess
import sys

import numpy as np
import pytest

from frictionbench.harness.cells.stored import stored_start
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.residual import fclib_error, relaxation_residual, residual, residual_floor
from frictionbench.problems.verify import verify
from frictionbench.solvers import Status, available, find, solve, solver
from tests.helpers.friction_problems import block, nothing, spatial

WARM = sorted(name for name, info in available().items() if info.warm_start and not info.missing)


@pytest.mark.parametrize("name", WARM)
@pytest.mark.parametrize(
    "start", [np.zeros((40, 2)), np.zeros((1, 3)), np.zeros(2), np.full((1, 2), np.nan), "start", [[None, 1]]]
)
def test_a_start_is_checked(name, start):
    info, method = find(name)
    problem = block() if 2 in info.dimension else spatial(0)
    with pytest.raises(InputError, match=r"^start: "):
        solve(problem, name, start=start)
    with pytest.raises(InputError, match=r"^start: "):
        method.solve(method.prepare(problem), 1e-8, None, start)


@pytest.mark.parametrize(
    ("fact", "value"),
    [
        ("name", "a b"),
        ("family", ""),
        ("model", "other"),
        ("dimension", 2),
        ("warm_start", 1),
        ("needs", "scipy"),
        ("lacks", ("hinges",)),
        ("variants", (1,)),
    ],
)
def test_facts_of_a_solver_are_checked(fact, value):
    facts = {"name": "checked", "family": "test", "model": "coulomb"} | {fact: value}
    with pytest.raises(ValueError, match=rf"^solver: {fact} must be .*, got "):
        solver(**facts)(type("Checked", (), {"solve": lambda self, problem, tol, limit, start=None: None}))
    for wrong in (type("Idle", (), {}), type("Idle", (), {"solve": lambda self, problem, tol: None}), lambda problem: None):
        with pytest.raises(ValueError, match=r"is no class with solve\(self, problem, tol, limit, start=None\)"):
            solver("checked", family="test", model="coulomb")(wrong)
    assert "checked" not in available()


@pytest.mark.parametrize("name", [*available()])
def test_an_unsymmetric_delassus_matrix_is_refused_by_methods_in_velocities(name):
    """Others solve their model with W as it is: its asymmetry is told from an error by a residual well below it."""
    W = np.array([[1.0, 0.3, 0.0, 0.1], [0.1, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.2], [0.1, 0.0, 0.0, 1.0]])
    problem = FrictionProblem.from_delassus(W, [-1.0, 0.4, -0.5, 0.3], [0.2, 0.4], 2)
    info = find(available()[name].specs[0])[0]
    if info.missing or info.refuses(block()):
        pytest.skip("cannot be used here")
    if "asymmetry" in info.lacks:
        assert info.refuses(problem) == f"{name} does not support asymmetry"
    elif (answer := solve(problem, info.specs[0], tol=1e-6)).status is Status.SOLVED:
        assert verify(problem, answer, info.model, 1e-6).verdict in ("solved", "relaxed")


def test_arguments_are_checked():
    invalid = {"limit": [0, -1, 1.5, True, "10", 10**9, np.nan], "tol": [0, -1.0, np.nan, np.inf, "1e-8", None, 1j]}
    for name, values in (invalid | {"problem": [np.eye(2)]}).items():
        for value in values:
            with pytest.raises(InputError, match=rf"^{name}: "):
                solve(**{"problem": block(), "solver": "apgd", name: value})


def test_an_answer_is_required(monkeypatch):
    monkeypatch.setattr(find("apgd")[1].__class__, "solve", lambda self, prepared, tol, limit, start=None: np.zeros((1, 2)))
    for call in (lambda: solve(block(), "apgd"), lambda: solve(block(), "apgd", time_limit=1.0)):
        with pytest.raises(InputError, match=r"^solver: apgd must return an Answer, got <class 'numpy.ndarray'>"):
            call()


@pytest.mark.parametrize("problem", [block(), spatial(0), spatial(0, joints=2)], ids=["plane", "space", "joints"])
def test_impulses_are_checked(problem):
    too_many = np.zeros((problem.contacts + 1000, problem.dimension))
    known_by_W = type(problem).from_delassus(problem.W, problem.q, problem.friction, problem.dimension)
    for one in (problem, known_by_W):
        for method in (one.velocity, one.contact_velocity, one.velocity_size):
            with pytest.raises(InputError, match=r"^impulse: "):
                method(too_many)
            with pytest.raises(InputError, match=r"^impulse: "):
                method(too_many[:0])
        for measure in (residual, relaxation_residual, fclib_error, residual_floor):
            assert measure(one, too_many) == np.inf
            assert measure(nothing(problem.dimension), too_many) == np.inf
    for method in (problem.lcp().impulse, problem.lcp().residual):
        with pytest.raises(InputError, match=r"^z: "):
            method(np.zeros(3))


def test_invalid_stored_start(tmp_path):
    (tmp_path / "problems").mkdir()
    path = tmp_path / "problems" / "abc.e3b0c442.starts.npz"
    for content in (b"PK no archive", b""):
        path.write_bytes(content)
        with pytest.raises(InputError, match=r"abc\.e3b0c442\.starts\.npz: .*start warm"):
            stored_start(tmp_path, "abc", "", "warm")
    np.savez(path, cold=np.zeros(2))
    with pytest.raises(InputError, match=r"abc\.e3b0c442\.starts\.npz: .*start warm"):
        stored_start(tmp_path, "abc", "", "warm")


CORE = """
import sys
from importlib import metadata
absent = ("clarabel", "osqp", "proxsuite", "h5py", "pooch", "distributed")
sys.modules.update(dict.fromkeys(absent))
known = metadata.version
def version(name):
    if name in absent:
        raise metadata.PackageNotFoundError(name)
    return known(name)
metadata.version = version
import frictionbench as fb
problem = fb.scene("stack", blocks=2, push=1.0).problem()
print(fb.verify(problem, fb.solve(problem, "nsgs"), 1e-8).verdict.value)
print(fb.available()["clarabel"].missing)
for path in ("p.hdf5", "p.npz"):
    try:
        fb.save(problem, path)
    except fb.InputError as error:
        print(error)
"""


def test_the_core_needs_none_of_the_extras(tmp_path):
    """Without them it is imported and solves; what needs one says which, and how it is installed."""
    done = subprocess.run([sys.executable, "-c", CORE], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    verdict, missing, saved = done.stdout.splitlines()
    assert verdict == "solved"
    assert missing == "clarabel not installed; pip install clarabel"
    assert saved == "h5py: not installed; pip install 'frictionbench[recorded]'"
