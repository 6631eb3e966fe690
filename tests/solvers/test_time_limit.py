"""A time limit in this process: it reaches every method and the members of a portfolio, and counts without one are the same."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import make_instance
from frictionbench.solvers import clock, merit_newton
from frictionbench.solvers.clock import TimeLimit, deadline, is_over, is_past, left
from frictionbench.solvers.interface import find

METHODS = ("lemke", "dantzig", "murty", "path_search", "fischer_newton", "nsgs", "admm_coulomb", "interior_point", "hybrid")


@pytest.fixture(scope="module")
def problem() -> FrictionProblem:
    """None of the methods solves it in its first step."""
    return fb.scene("stack", blocks=6, push=1.0).problem()


@pytest.mark.parametrize("spec", METHODS)
def test_time_is_over_at_once(spec: str, problem: FrictionProblem) -> None:
    answer = fb.solve(problem, spec, time_limit=1e-9)
    assert answer.status is fb.Status.TIME_LIMIT
    assert answer.detail == f"after 1e-09 s, with a residual of {fb.residual(problem, answer.impulse):.2g}"
    assert answer.work.get("members", 1) == 1


@pytest.mark.parametrize(
    "spec", ["admm", "admm_coulomb", "interior_point", "relaxation_ip", "proximal_newton", "fischer_newton", "minmap_newton"]
)
def test_a_factorisation_that_would_not_end_in_time_is_not_begun(
    spec: str, problem: FrictionProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A machine so slow that one takes longer than the limit, of which next to nothing passes."""
    for module in (clock, merit_newton):
        monkeypatch.setattr(module, "SPEED", 1e-9)
    given = make_instance("cubes", boxes=2, push=1.0) if spec == "proximal_newton" else problem
    answer = fb.solve(given, spec, time_limit=1e6)
    assert answer.status is fb.Status.TIME_LIMIT
    assert answer.work["factorisations"] == 0
    assert fb.residual(given, answer.impulse) <= fb.residual(given, 0 * answer.impulse)
    assert fb.solve(given, spec).work["factorisations"] > 0


def test_admm_keeps_its_penalty_where_there_is_no_time_for_another(
    problem: FrictionProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, method = find("admm_coulomb")
    prepared = method.prepare(problem)
    free = method.solve(prepared, 1e-8, 40)
    monkeypatch.setattr(clock, "SPEED", 1e-9)
    with TimeLimit(1e6):
        held = method.solve(prepared, 1e-8, 40)
    assert held.work["iterations"] == free.work["iterations"] == 40
    assert held.work["factorisations"] == 1 < free.work["factorisations"]


def test_lemke_begins_from_nothing_where_there_is_no_time_to_invert_a_guessed_basis(
    problem: FrictionProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = fb.solve(problem, "lemke").impulse
    assert fb.solve(problem, "lemke", start=start, time_limit=1e6).work["inversions"] > 0
    monkeypatch.setattr(clock, "SPEED", 1e-9)
    cold = fb.solve(problem, "lemke", start=start, time_limit=1e6)
    assert cold.status is fb.Status.SOLVED
    np.testing.assert_array_equal(cold.impulse, start)


@pytest.mark.parametrize("spec", ["lemke", "hybrid"])
def test_time_enough_changes_nothing(spec: str, problem: FrictionProblem) -> None:
    free, limited = fb.solve(problem, spec), fb.solve(problem, spec, time_limit=1e6)
    np.testing.assert_array_equal(free.impulse, limited.impulse)
    assert (free.status, free.work) == (limited.status, limited.work)


@pytest.mark.parametrize("seconds", [0.0, -1.0, np.inf, np.nan, True, "1"])
def test_invalid(seconds: object, problem: FrictionProblem) -> None:
    with pytest.raises(fb.InputError, match="time_limit"):
        fb.solve(problem, "lemke", time_limit=seconds)  # type: ignore[arg-type]


def test_limits_nest() -> None:
    assert (deadline(), deadline(1e9), left(), is_over()) == (np.inf, np.inf, np.inf, False)
    with TimeLimit(1e6):
        outer = deadline()
        assert deadline(clock.SPEED) == pytest.approx(outer - 1.0)
        assert not is_past(outer)
        with TimeLimit(1e9):
            assert deadline() == outer
        with TimeLimit(-1.0):
            assert is_over()
            assert is_past(deadline())
        assert not is_over()
    assert deadline() == np.inf
