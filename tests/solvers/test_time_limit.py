"""A time limit in this process: it reaches every method and the members of a portfolio, and counts without one are the same."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.problems import FrictionProblem
from frictionbench.solvers.clock import deadline, is_over, left, within

METHODS = ("lemke", "dantzig", "murty", "path_search", "fischer_newton", "nsgs", "interior_point", "hybrid")


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


@pytest.mark.parametrize("spec", ["lemke", "hybrid"])
def test_time_enough_changes_nothing(spec: str, problem: FrictionProblem) -> None:
    free, limited = fb.solve(problem, spec), fb.solve(problem, spec, time_limit=1e6)
    np.testing.assert_array_equal(free.impulse, limited.impulse)
    assert (free.status, free.work) == (limited.status, limited.work)


def test_a_bare_lcp() -> None:
    answer = fb.solve(fb.LCP([[2.0, 1.0], [1.0, 2.0]], [-3.0, -3.0]), "lemke", time_limit=1e-9)
    assert answer.status is fb.Status.TIME_LIMIT


@pytest.mark.parametrize("seconds", [0.0, -1.0, np.inf, np.nan, True, "1"])
def test_invalid(seconds: object, problem: FrictionProblem) -> None:
    with pytest.raises(fb.InputError, match="time_limit"):
        fb.solve(problem, "lemke", time_limit=seconds)  # type: ignore[arg-type]


def test_limits_nest() -> None:
    assert (deadline(), left(), is_over()) == (np.inf, np.inf, False)
    with within(1e6):
        outer = deadline()
        with within(1e9):
            assert deadline() == outer
        with within(-1.0):
            assert is_over()
        assert not is_over()
    assert deadline() == np.inf
