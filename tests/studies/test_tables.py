"""Each study at reduced size: what its tables must show, and its text and figures from them."""

import re

import numpy as np
import pytest

from studies.cone import SPACE
from studies.exactness import STUDY
from studies.outcomes import answers, digits
from studies.study import order
from tests.helpers.studies import reduced, text

pytestmark = pytest.mark.slow  # claims on computed tables, which take seconds


def test_springs_tend_to_the_rigid_motion_and_decide_between_two() -> None:
    found = reduced(
        "compliance",
        stiffnesses={"names": ("stopping_block",), "values": (1e4, 1e5, 1e6), "methods": ("Radau", "BDF")},
        indentations={"shares": (0.5, 2.0)},
        inconsistent={"values": (1e6, 1e7, 1e8)},
    )
    errors, stuck = found["stiffnesses"].groupby("method")["error"], found["inconsistent"]
    assert all(error.is_monotonic_decreasing for _, error in errors)
    off = (stuck["impulse"] / stuck["rigid"] - 1).abs()
    assert off.is_monotonic_decreasing
    assert off[2] < 0.02
    ratio = (found["stiffnesses"]["work"] / found["stiffnesses"]["rigid_work"])[5]  # by BDF at the largest stiffness
    assert f"with {ratio:.2g} to {ratio:.3g} times the evaluations" in text("compliance", found)["answer"]


def test_polygons_bend_the_path_and_approach_the_cone() -> None:
    found = reduced(
        "cone",
        ball={"facets": (0, 4, 8, 16), "step": 0.01, "turns": 3},
        problems={"facets": (4, 8, 16), "sources": SPACE[1:2], "turns": 3},
        interior={"facets": (0, 4, 8), "sources": SPACE[1:2], "repeats": 1},
    )
    ball, problems = found["ball"], found["problems"]
    assert ball[ball["facets"] > 0].groupby("facets")["from_cone"].mean().is_monotonic_decreasing
    assert problems.groupby("facets")["error"].mean().is_monotonic_decreasing
    assert found["interior"]["solved"].all()
    assert problems["solutions_apart"].max() < 1e-8
    assert text("cone", found)["answer"].startswith("The cone")


def test_the_jam_is_a_bent_line_and_the_block_is_unique_where_it_is_p0() -> None:
    found = reduced(
        "convexity",
        jam={"points": 9},
        block={"frictions": (0.5, 3.0), "aspects": (1.0,), "draws": 30},
        motions={"names": ("example_4",), "steps": 30, "most": 3},
    )
    jam, block = found["jam"], found["block"]
    assert jam["residual"].max() < 1e-12
    assert (jam["middle_residual"] > 1e-3).tolist() == (jam["share"] > 1).tolist()
    assert jam["middle_gap"].iloc[-1] == 0.25
    assert block["several_velocities"].gt(0).tolist() == [False, True]
    account = text("convexity", found)
    assert account["answer"].startswith("No, as two examples in the plane show")
    assert list(dict.fromkeys(re.findall(r"convexity_(\w+)\.svg", account["body"]))) == ["jam", "block"]


def test_hinges_drift_and_angles_do_not() -> None:
    found = reduced(
        "coordinates",
        drifts={"schemes": ("anitescu_potra",), "counts": (20, 40, 80), "duration": 0.004},
        free={"schemes": ("stewart_trinkle",), "counts": (20, 40, 80)},
    )
    drifts = found["drifts"]
    assert drifts[drifts["form"] == "angles"]["drift"].max() < 1e-12
    assert drifts[drifts["form"] == "hinges"]["drift"].min() > 1e-6
    free = found["free"].groupby(["speed", "form"]).apply(lambda rows: order(rows["step"], rows["error"]).value)
    assert free[150, "hinges"] > 1.8, "SHAKE with one Newton step, gravity small beside the reactions"
    assert free[150, "angles"] < 1.2
    assert text("coordinates", found)["answer"].startswith("By algebra, in the same configuration W is the same")


def test_events_are_exact_and_steps_are_of_first_order() -> None:
    found = reduced(
        "events",
        errors={"names": ("bouncing_ball",), "counts": (20, 40, 80), "accuracies": (1e-6,)},
        ends={"cases": (("bouncing_ball", {"restitution": 0.5}, 2.0), ("painleve_rod", {}, 0.2))},
    )
    errors, ends = found["errors"], found["ends"]
    driven = errors["scheme"] == "event_driven"
    assert errors[driven]["error"].max() < 1e-9
    assert errors[~driven]["error"].min() > 1e-5
    assert "trapezoid" in set(errors["scheme"]), "as a scheme of second order"
    assert ends["accumulations"].tolist() == [1, 0]
    assert ends["reached"].round(9).tolist() == [2.0, 0.0]
    assert "no bounded force" in ends["reason"][1]
    assert text("events", found)["answer"].startswith("Event-driven where accuracy is asked for")


def test_the_rods_impulse_tends_to_the_limit() -> None:
    arguments = {"scenes": ("rod",), "solvers": ("lemke", "interior_point"), "steps": (0.02, 0.01, 0.005)}
    rows = reduced("inclusion", refinement=arguments)
    table = rows["refinement"]
    away = np.abs(table.loc[table["solver"] == "lemke", "largest"] - 0.9)
    assert away.is_monotonic_decreasing
    assert away.iloc[-1] < 0.06
    assert "settle, to 5 % of the largest component in the last halving, in 2 of 2 pairs" in text("inclusion", rows)["answer"]


def test_the_predictor_corrector_solves_most_problems() -> None:
    found = reduced(
        "interior",
        random={"frictions": (0.3, 3.0), "contacts": (5,), "seeds": 3},
        piles={"frictions": (0.2,), "blocks": (1, 10)},
        threshold={"ratios": (0.5, 3.0), "draws": 6},
    )
    random, threshold = found["random"], found["threshold"]
    assert random.loc[random["friction"] < 1, ["plain", "paths", "relaxation"]].all().all()
    assert threshold["p0"].tolist() == [True, False]
    assert threshold.loc[threshold["p0"], "plain"].tolist() == [6]
    assert found["piles"]["plain"].all()
    assert text("interior", found)["answer"].startswith("In the plane, mostly")


def test_the_relaxation_errs_by_the_closed_forms() -> None:
    found = reduced("relaxation", errors={"frictions": (0.1, 0.4, 0.8), "steps": (1e-3,)}, gaps={"steps": (0.02, 0.01, 0.005)})
    gaps = found["gaps"]
    assert gaps["coulomb"].max() < 1e-9
    assert np.allclose(gaps["smooth"], gaps["smooth_predicted"], rtol=0.02)
    assert np.ptp(gaps["hop"]) < 0.2 * gaps["hop"].min()
    by_push = found["errors"].groupby("push")["error"].median()
    assert by_push["sudden"] > 0.05
    assert by_push["smooth"] < by_push["sudden"]
    found["gaps"]["hop_predicted"] = gaps["hop"]  # the steps are too large for the limit
    assert text("relaxation", found)["answer"].startswith("By the relaxation of Anitescu, not in general")


def test_a_pile_of_discs_has_several_motions_and_digits_of_residual_are_digits_of_velocity() -> None:
    pile = (("disc_pile", {"rows": 5, "push": 0.1}),)
    found = reduced(
        "outcomes",
        answers={"scenes": (*pile, ("random_bodies", {"contacts": 8})), "frictions": (0.8,), "starts": 1},
        digits={"scenes": (("pyramid", {"rows": 3, "push": 1.0}),), "frictions": (0.8,), "ladder": (1e-2, 1e-4, 1e-6, 1e-8)},
    )
    assert found["answers"]["outcome"].max() >= 1
    assert (found["digits"].query("residual < 1e-9")["error"] < 1e-7).all()
    assert "several were found in 1 of 2 with mu up to 0.8" in text("outcomes", found)["answer"]


def test_no_solve_is_ended_by_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("frictionbench.solvers.interface.TimeLimit", None)  # called where a solve has a time limit
    pyramid = (("pyramid", {"rows": 3, "push": 1.0}),)
    assert all(row["outcome"] >= 0 for row in answers(pyramid, (0.8,), 0))
    assert {row["tol"] for row in digits(pyramid, (0.8,), (1e-4,))} == {1e-4}


@pytest.mark.skipif(not STUDY.runs(), reason="packages of robots are not installed")
def test_the_error_of_a_path_follows_the_tolerance() -> None:
    robots, tasks = {"names": ("humanoid",)}, {"names": ("grasp", "hinge"), "duration": 0.1}
    found = reduced("exactness", paths=robots, others=robots | {"seeds": (1,)}, tasks=tasks)
    error = found["paths"].set_index("way")["error"]
    assert error["1e-01"] > 1e2 * error["1e-06"] > 1e4 * error["1e-10"]
    assert error["twin"] < 1e-9
    moved = found["tasks"].set_index(["way", "task"])["moved"]
    assert moved["reference", "hinge"] < 1e-9 < moved["MuJoCo", "hinge"]
    assert moved["interior point", "grasp"] < 1 < moved["1e-10", "grasp"], "both exact"
    assert text("exactness", found)["answer"].startswith("It depends on the motion: of 1 models, chosen")


def test_substeps_help_while_each_converges() -> None:
    found = reduced("substeps", errors={"scenes": ("pyramid",), "budgets": (16, 64), "substeps": (1, 4, 16)})
    errors, own = (found["errors"].set_index(["budget", "substeps"])[name] for name in ("error", "own"))
    assert errors[0].is_monotonic_decreasing, "of exact steps"
    assert errors[64, 16] < 0.5 * errors[64, 1]
    assert errors[16, 16] > errors[16, 4], "one sweep in a substep"
    assert own[64, 1] < 1e-3 * errors[0, 1] < 0.1 * own[16, 16]
    assert "in 2 cases, substeps are better in 2, one step in 0 and neither in 0" in text("substeps", found)["answer"]


def test_single_precision_reaches_what_is_coarse() -> None:
    cases = {"cases": ("ant-harsh-159", "cheetah-smooth-119")}
    found = reduced("precision", rounded=cases, reached=cases | {"limits": (50, 500)})
    last = found["reached"].query("limit == 500").groupby("precision")["residual"].agg(["min", "max"])
    assert found["rounded"]["residual"].between(1e-10, 1e-6).all()
    assert last.loc["single", "max"] < 1e-5
    assert last.loc["double", "max"] < last.loc["single", "min"]
    assert "bring as many of 2 steps of robots" in text("precision", found)["answer"]
