"""hybrid: which member comes first, and when an answer is as good as can be told."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.packed import pack
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.scenes import scene
from frictionbench.solvers import clock
from frictionbench.solvers.interface import Answer, Status, find, solve
from frictionbench.solvers.portfolio.few_pivots import few_pivots, few_pivots_each
from frictionbench.solvers.portfolio.shares import BROUGHT

FIRST_BY_PIVOTS = {
    "a small random problem": (random_problem(1, 30), True),
    "a large random problem": (random_problem(1, 50), False),
    "a stack with one body pushed": (scene("stack", blocks=25, push=1.0).problem(), True),
    "a stack in which all contacts slip": (scene("stack", blocks=25, shear=1.0).problem(), False),
    "a long stack": (scene("stack", blocks=40, push=1.0).problem(), False),
    "a pyramid": (scene("pyramid", rows=5).problem(), False),
}


@pytest.mark.parametrize("name", FIRST_BY_PIVOTS)
def test_pivots_come_first_in_small_problems_and_sticking_chains(name: str) -> None:
    problem, first = FIRST_BY_PIVOTS[name]
    answer = solve(problem, "hybrid")
    assert few_pivots(problem) is first
    assert answer.status is Status.SOLVED
    assert ("lemke pivots" in answer.work) is first


def test_packed_problems_are_told_apart_in_the_same_way() -> None:
    problems: list[FrictionProblem] = [problem for problem, _ in FIRST_BY_PIVOTS.values()]
    bare = FrictionProblem.from_delassus(problems[2].W, problems[2].q, problems[2].friction, 2)
    problems.append(bare)
    np.testing.assert_array_equal(few_pivots_each(pack(problems)), [few_pivots(problem) for problem in problems])


def test_a_claim_within_the_floor_of_rounding_is_an_answer() -> None:
    """A block of 1e10 times the mass of the one below it: no impulses have a residual that can be told from 1e-6."""
    answer = solve(scene("stack", blocks=4, mass_ratio=1e10, push=1.0).problem(), "hybrid")
    assert answer.status is Status.ROUNDING
    assert answer.work["members"] == 2  # a second one, which might find smaller impulses, and no more


@pytest.mark.parametrize(("dimension", "first"), BROUGHT)
def test_a_time_limit_is_divided_by_what_members_brought(dimension: int, first: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a clock that stands still, so that no member uses any of its time: each has its share of the whole limit."""
    problem = (
        random_problem(1, 40 if first == "interior_point" else 4) if dimension == 2 else cubes(1 if first == "nsgs" else 3)
    )
    monkeypatch.setattr(clock, "_now", lambda: 100.0)
    given: list[float] = []

    def nothing(self: object, prepared: object, tol: float, limit: int | None, start: object = None) -> Answer:
        given.append(clock.left())
        return Answer(np.zeros((problem.contacts, dimension)), Status.STALLED)

    for name in BROUGHT[dimension, first]:
        monkeypatch.setattr(type(find(name)[1]), "solve", nothing)
    assert solve(problem, "hybrid", time_limit=10.0).work["members"] == len(given) == len(BROUGHT[dimension, first])
    chance = np.array([count + 1 for count in BROUGHT[dimension, first].values()])
    np.testing.assert_allclose(given, [10.0 * chance[k] / chance[k:].sum() for k in range(len(chance))])
