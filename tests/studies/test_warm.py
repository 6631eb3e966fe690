"""The account of warm starts, from made rows: problems without all three starts and unsolved ones are left out."""

import json

import pandas as pd

from frictionbench.harness.studies.warm import SOLVERS
from frictionbench.reports.studies.warm import COUNTS
from tests.helpers.studies import reduced, told


def rows(variant: str, warm: int, shuffled: int) -> list[dict[str, object]]:
    """Two motions of three problems; the first problem of each has no step before it."""
    return [
        {"variant": variant, "scene": scene, "problem": f"{scene}{k}", "step": k, "phase": "step", "start": start}
        | {"verdict": "solved", "work": json.dumps({COUNTS[variant]: count})}
        for scene in ("a", "b")
        for k in range(3)
        for start, count in (("cold", 1000 if k == 0 else 20), ("warm", warm), ("shuffled", shuffled))
        if k or start != "warm"
    ]


def test_only_problems_with_all_three_starts_are_compared() -> None:
    made = pd.DataFrame(rows("lemke", 5, 10) + rows("nsgs", 20, 30))
    account = told(reduced("warm", {"solves": made}))
    assert account.answer.startswith("From the step before, methods take 0.25 (lemke) to 1.00 (nsgs) of their work from zero")
    assert "for 1 of 2 the 95 % interval is below 1" in account.answer
    assert "Of 4 problems with all three starts" in account.result
    made.loc[(made["variant"] == "nsgs") & (made["step"] == 2) & (made["start"] == "warm"), "verdict"] = "unsolved"
    account = told(reduced("warm", {"solves": made}))
    assert "From the step before fewer problems are solved by nsgs." in account.result


def test_every_method_compared_has_a_count() -> None:
    assert set(COUNTS) == set(SOLVERS)
