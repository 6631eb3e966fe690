"""Independent coordinates or multipliers, at reduced size."""

from tests.helpers.studies import reduced, told


def test_hinges_drift_and_solvers_see_the_same_problem() -> None:
    found = reduced(
        "coordinates",
        drifts={"schemes": ("anitescu_potra",), "counts": (20, 40, 80), "duration": 0.004},
        problems={"solvers": ("lemke",), "steps": 60},
    )
    drifts, problems = found["drifts"], found["problems"]
    assert drifts[drifts["form"] == "angles"]["drift"].max() < 1e-12
    assert drifts[drifts["form"] == "hinges"]["drift"].min() > 1e-6
    assert problems["difference"].max() < 1e-9
    assert problems["work_angles"].tolist() == problems["work_hinges"].tolist()
    assert told(found).answer.startswith("To the solvers it is the same")
