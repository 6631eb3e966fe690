"""The recorded steps of robots: what the table says of them is true, their answers and starts are those of the files."""

import numpy as np
import pytest

from frictionbench.harness.cells.collect import collect
from frictionbench.harness.cells.stored import stored_start
from frictionbench.harness.plans.robots import ARRAYS, TABLE, kept, steps, table
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems.analysis.frictionless import idle
from frictionbench.problems.analysis.labels import labels
from frictionbench.problems.catalogue import make_instance
from frictionbench.problems.instances.recorded_step import ROBOTS, recorded_steps
from frictionbench.problems.residual import residual
from frictionbench.results.conventions import COLD, WARM
from frictionbench.solvers import solve

ROWS = table(TABLE)
NAMES = [row["case"] for row in ROWS]


def problem_of(row):
    return make_instance("robot_step", case=row["case"])


def test_table_files_and_arrays_name_the_same_steps() -> None:
    assert sorted(NAMES) == recorded_steps(ROBOTS)
    with np.load(ARRAYS) as arrays:
        assert set(arrays.files) == {*NAMES, *(f"{name} start" for name in NAMES)}
    assert [source.parameters["case"] for source in steps()] == NAMES


@pytest.mark.parametrize("row", ROWS, ids=NAMES)
def test_what_is_kept_is_that_problem_and_its_answer(row) -> None:
    problem, answer, start = problem_of(row), kept(row["case"]), kept(f"{row['case']} start")
    assert problem.hash == row["hash"]
    assert problem.contacts == sum(int(row[name]) for name in ("contacts", "limits", "dry_friction"))
    assert residual(problem, answer) <= 1e-8
    assert start.shape == answer.shape
    assert (problem.bias >= 0).all()  # so that a solution exists
    assert not problem.joint_bias.any()


@pytest.mark.parametrize("row", ROWS[::12], ids=NAMES[::12])
def test_labels_and_friction_are_as_said(row) -> None:
    problem = problem_of(row)
    found = labels(problem)
    assert (found["limits"], found["dry_friction"]) == (int(row["limits"]), int(row["dry_friction"]))
    assert not found["trivial"]
    assert not idle(problem, lambda other: solve(other, "hybrid", tol=1e-10).impulse)


def test_two_methods_agree_but_where_the_table_says_so() -> None:
    verified = [row["verified"].split(", ") for row in ROWS]
    assert all(len(methods) >= 2 for row, methods in zip(ROWS, verified, strict=True) if row["case"] not in ALONE)
    assert len([row for row in ROWS if float(row["apart"]) > 1e-6]) < 0.1 * len(ROWS)


ALONE = ("fetch_pick-hit-004", "fetch_slide-hit-004")  # by sweeps alone: rounding in W's root leaves others at 3e-8


def test_a_recorded_step_is_started_warm_in_the_suite(tmp_path) -> None:
    source = steps()[0]
    [record] = collect(tmp_path, source)
    assert set(record["starts"]) == {COLD, WARM}
    origin = f"{source.scene} {record['parameters']} {record['step']} {record['phase']}"
    start = stored_start(tmp_path, record["problem"], origin, WARM)
    assert np.array_equal(start, kept(f"{source.parameters['case']} start"))
    assert WARM in SUITES["robots"]().starts
