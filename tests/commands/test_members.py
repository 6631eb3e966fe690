"""The part of the page of performance on hybrid's members and PATH, on the smallest problems."""

from types import SimpleNamespace

import pytest

from frictionbench.commands import members
from frictionbench.problems import FrictionProblem


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"ROUNDS": 1, "SHORT": 0.0, "STACKS": {2: (1,), 3: (1,)}, "PATHS": (("stack", "blocks", (2,)),)}.items():
        monkeypatch.setattr(members, name, value)


def test_ratios_are_to_the_fastest_member_that_solves(monkeypatch: pytest.MonkeyPatch) -> None:
    inf = float("inf")
    seconds = {"hybrid": 3.0, "lemke": 2.0, "nsgs": inf, "interior_point": 4.0}
    monkeypatch.setattr(members, "_in_turn", lambda problem, specs: {spec: seconds[spec] for spec in specs})
    monkeypatch.setattr(members, "available", lambda: {"path": SimpleNamespace(missing="gamspy not installed")})
    text = members.section()
    assert "| 1 | 2 | 1.50 | lemke |" in text
    assert "| 1 | 4 | 0.75 | interior_point |" in text
    assert "| stack, blocks = 2 | 16 | – |" in text


def test_times_of_what_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(members, "TOL", 1e-6)
    problem: FrictionProblem = members.scene("stack", blocks=2, push=1.0).problem()
    found = members._in_turn(problem, ("lemke", "apgd"))
    assert 0 < found["lemke"] < 10
    assert found["apgd"] == float("inf")  # the relaxation is another model


def test_path_by_its_own_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(members, "available", lambda: {"path": SimpleNamespace(missing=None)})
    monkeypatch.setattr(members, "_own_time", lambda problem: 1.0)
    true = members.solve

    def clocked(problem: FrictionProblem, spec: str, tol: float) -> object:
        answer = true(problem, "lemke", tol=tol)
        answer.clock = 4.0
        return answer

    monkeypatch.setattr(members, "solve", clocked)
    assert "| stack, blocks = 2 | 16 | 0.25 |" in members._path()
