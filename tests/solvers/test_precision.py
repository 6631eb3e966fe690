"""Single precision: what its sweeps reach, what they claim, and that they are asked for, and ranked at, 1e-6 and coarser."""

import numpy as np
import pandas as pd
import pytest

import frictionbench as fb
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.problems.verdicts import Verdict
from frictionbench.reports.accuracy import times_to
from frictionbench.solvers import Status, find, solve, solve_many
from frictionbench.solvers.sweeps.form import contact_form
from tests.helpers.friction_problems import spatial

STEP = fb.instance("robot_step", case="humanoid-smooth-154")


@pytest.mark.parametrize("spec", ["nsgs", "apgd_coulomb", "admm_coulomb", "apgd", "admm"])
def test_sweeps_in_single_precision_end_near_its_rounding(spec) -> None:
    """Claims hold, and far below 1e-6 there is no progress, where double precision goes on."""
    measure = residual if find(spec)[0].model == "coulomb" else relaxation_residual
    single, ends = f"{spec}[precision=single]", []
    for problem in (random_problem(3, contacts=4), scene("stack", blocks=3, push=1.0).problem(), spatial(1, contacts=6), STEP):
        answer = solve(problem, single, tol=1e-4)
        assert answer.impulse.dtype == np.float64
        assert answer.status is Status.SOLVED
        assert measure(problem, answer.impulse) <= 1e-4
        assert solve(problem, single, tol=1e-4, start=answer.impulse).status is Status.SOLVED
        ends.append(measure(problem, solve(problem, single, tol=1e-15, limit=3000).impulse))
    assert max(ends) > 1e-9
    assert np.median(ends) < 1e-5


def test_its_form_is_single_throughout() -> None:
    kinds = {part.dtype for part in contact_form(STEP, precision="single")}
    assert kinds == {np.dtype(np.float32), np.dtype(np.int32)}


def test_packed_problems_are_solved_one_by_one() -> None:
    problems = [scene("stack", blocks=1, push=push).problem() for push in (0.5, 1.0)]
    answers = solve_many(problems, "nsgs[precision=single]", tol=1e-4)
    alone = [solve(problem, "nsgs[precision=single]", tol=1e-4) for problem in problems]
    assert answers.solved.all()
    assert all(np.array_equal(answers[k], answer.impulse) for k, answer in enumerate(alone))


def test_an_unknown_precision_is_refused() -> None:
    with pytest.raises(InputError, match=r"nsgs\[precision=half\].*one of double, single"):
        find("nsgs[precision=half]")


def test_a_plan_asks_single_precision_for_its_finest_target_too() -> None:
    """And for tighter ones, which the worker skips with the reason."""
    plan = Plan("made", (Source("stack"),), ("nsgs", "nsgs[precision=single]"), (1e-4, 1e-8))
    record = {
        "problem": "p",
        "scene": "stack",
        "parameters": "{}",
        "step": 0,
        "phase": "step",
        "dimension": 2,
        "starts": {"cold": ""},
    }
    cells = [(cell.variant, cell.tol) for cell in plan.solve_cells([record])]
    assert cells == [("nsgs", 1e-4), ("nsgs", 1e-8), *[("nsgs[precision=single]", tol) for tol in (1e-4, 1e-6, 1e-8)]]
    reasons = [find(variant)[0].too_tight(tol) for variant, tol in cells]
    assert reasons == [None] * 4 + ["single precision: not asked for less than 1e-06"]


def test_single_precision_is_not_ranked_where_it_was_not_asked() -> None:
    asked = {"double": (1e-4, 1e-8), "single": (1e-4, 1e-6)}
    rows = [
        {"label": label, "tol": tol, "verdict": Verdict.SOLVED, "residual": tol / 2, "answered": True, "reason": ""}
        for label, tols in asked.items()
        for tol in tols
    ]
    rows.append({"label": "single", "tol": 1e-8, "verdict": Verdict.SKIPPED, "residual": np.nan, "answered": False})
    same = {"problem_id": 0, "problem_class": "made", "stratum": "made", "dimension": 2, "scene": "made", "cluster": "made"}
    same |= {"model": "coulomb", "start": "cold", "host": "", "time_limit": 1.0, "work": "{}", "residual_floor": 0.0}
    times = {
        name: value
        for part in ("form", "setup", "solve")
        for name, value in ((f"{part}_time", 1e-3), (f"{part}_times", [1e-3]))
    }
    table = pd.DataFrame([same | times | row for row in rows])
    ranked = {target: set(times_to(table, target)["label"]) for target in (1e-4, 1e-6, 1e-8)}
    assert ranked == {1e-4: {"double", "single"}, 1e-6: {"double", "single"}, 1e-8: {"double"}}
