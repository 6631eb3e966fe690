"""Failing cells are reduced to smaller problems that still fail."""

import os
import shlex

import numpy as np
import pytest

from frictionbench.commands.shrink import fails_as, reduced, shrink
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.run import run
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded.native import load
from frictionbench.problems.subproblems import keep_contacts
from frictionbench.results import store
from frictionbench.results.files import ResultsError
from tests.helpers.command_line import frictionbench
from tests.helpers.paths import BAD_SOLVERS
from tests.helpers.runs import quiet


def test_reduction_finds_minimum() -> None:
    asked = []

    def fails(parts: list[int]) -> bool:
        asked.append(parts)
        return {3, 17} <= set(parts)

    assert reduced(list(range(40)), fails) == [3, 17]
    assert 5 < len(asked) < 80
    assert reduced([5], fails) == [5]


def test_parts_below_rounding_floor_are_ignored() -> None:
    row = {"verdict": "unsolved", "tol": 1e-6}
    assert fails_as(row, {"verdict": "unsolved", "residual_floor": 1e-12})
    assert not fails_as(row, {"verdict": "unsolved", "residual_floor": 9.4})
    assert not fails_as(row, {"verdict": "wrong"})


def test_contacts_and_bodies_are_removed() -> None:
    tower = scene("stack", blocks=3, push=1.0).problem()
    on_ground = np.flatnonzero(np.diff(tower.normal.indptr) <= 3).tolist()
    base = keep_contacts(tower, on_ground)
    rows = np.array([2 * i + k for i in on_ground for k in (0, 1)])
    assert (base.contacts, len(base.free_velocity)) == (2, 3)
    assert np.array_equal(base.W.toarray(), tower.W.toarray()[np.ix_(rows, rows)])
    assert np.array_equal(base.q, tower.q[rows])
    problem = random_problem(3, contacts=6)
    known = FrictionProblem.from_delassus(problem.W, problem.q, problem.friction, 2)
    assert np.allclose(keep_contacts(known, [4, 1]).W.toarray(), keep_contacts(problem, [4, 1]).W.toarray())
    assert keep_contacts(problem, []).contacts == 0


def test_shrink_writes_a_file(tmp_path, monkeypatch) -> None:
    _, plugins = load_plugins([str(BAD_SOLVERS)])
    plan = Plan("test", (Source("stack", {"blocks": 4, "push": 1.0}),), ("wrong_zero", "lemke"), (1e-8,), plugins=plugins)
    run(plan, tmp_path, 1, quiet())
    (shard,) = tmp_path.glob("shards/solves-*")  # edited by someone else
    shard.write_text(shard.read_text(encoding="utf-8").replace('"solver": "wrong_zero"', '"solver": "../x"'), encoding="utf-8")
    rows = store.read_table(tmp_path, "solves").set_index("solver")
    path, problem, _, command = shrink(tmp_path, rows.loc["wrong_zero", "key"], [str(BAD_SOLVERS)])
    assert (path.parent.name, problem.contacts, len(problem.free_velocity), load(path).hash) == ("shrunk", 1, 3, problem.hash)
    assert "  wrong_zero  wrong  " in frictionbench("rerun", str(tmp_path)).stdout
    assert shlex.split(command)[2:] == [str(path), "--solver", os.path.relpath(BAD_SOLVERS), "--tol", "1e-08"]
    with pytest.raises(InputError, match="only failing rows can be shrunk"):
        shrink(tmp_path, rows.loc["lemke", "key"], [])
    with pytest.raises(ResultsError, match=r"no row has the key.*lists those that failed"):
        shrink(tmp_path, "nonsense", [])
    monkeypatch.setattr("frictionbench.commands.shrink.row_of", lambda *_: {"verdict": "timeout", "reason": "its limit"})
    with pytest.raises(InputError, match=r"was wrong and is timeout \(its limit\) from a cold start.*longer --time-limit"):
        shrink(tmp_path, rows.loc["wrong_zero", "key"], [str(BAD_SOLVERS)])
