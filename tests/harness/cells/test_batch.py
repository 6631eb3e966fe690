"""Batches: the same problems each time, verified in every way, and what starts warm."""

import json
from itertools import count

import numpy as np
import pytest

from frictionbench.harness.cells import batch
from frictionbench.harness.cells.batch import batch_of, time_batch
from frictionbench.harness.plans.plan import BatchCell
from frictionbench.reports.batches import rate_of
from frictionbench.solvers import Answer, find, solve_many

SIZES = [("stack", {"blocks": 1}, 2, 2), ("cubes", {"boxes": 1}, 3, 4)]


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"ROUNDS": 3, "SAMPLE": 2}.items():
        monkeypatch.setattr(batch, name, value)


@pytest.mark.parametrize(("scene", "parameters", "dimension", "contacts"), SIZES)
def test_problems_are_the_same_each_time(scene: str, parameters: dict[str, int], dimension: int, contacts: int) -> None:
    one, other = (batch_of.__wrapped__(scene, json.dumps(parameters), 3) for _ in range(2))
    assert [problem.hash for problem in one.problems] == [problem.hash for problem in other.problems]
    assert len({problem.hash for problem in one.problems}) == 3
    assert (one.facts["dimension"], one.facts["contacts"], one.facts["active"]) == (dimension, contacts, 1.0)


def test_it_starts_warm_near_the_answers() -> None:
    found = batch_of("stack", json.dumps({"blocks": 1}), 3)
    answers = solve_many(found.problems, "lemke")
    assert 0 < np.abs(found.start - answers.impulse).max() < 0.05 * np.abs(answers.impulse).max()


@pytest.mark.parametrize("way", ["calls", "packed", "list"])
def test_every_way_is_timed_and_verified(way: str) -> None:
    cell = BatchCell("stack", {"blocks": 1}, 4, "lemke", way, 1e-8)
    row = time_batch(cell, batch_of("stack", json.dumps(cell.parameters), 4), find("lemke")[0])
    assert (row["verdict"], row["verified"], len(row["times"])) == ("solved", 1.0, 3)
    assert json.loads(row["work"])["pivots"] > 0
    row |= vars(cell) | {"model": "lcp", **batch_of("stack", '{"blocks": 1}', 4).facts, **row}
    assert float(rate_of(row)[3].replace(",", "")) > 0


@pytest.mark.parametrize("when", range(4))
def test_what_is_not_solved_has_the_worst_verdict(when: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop that at first or in one round solves all problems but one, and claims that one too."""
    problems, call = batch_of("stack", '{"blocks": 1}', 4), count()
    answers = solve_many(problems.problems, "lemke")
    solved, given = ([Answer(answers[k] * (k != left), answers.status[k]) for k in range(4)] for left in (None, 2))
    monkeypatch.setattr(batch, "_way", lambda *_: lambda: given if next(call) == when else solved)
    row = time_batch(BatchCell("stack", {"blocks": 1}, 4, "lemke", "calls", 1e-8), problems, find("lemke")[0])
    assert (row["verdict"], row["verified"], row["reason"]) == ("wrong", 0.75, "1 of 4 wrong")
