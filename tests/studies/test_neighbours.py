"""Neighbouring starts part at edges, at reduced size."""

import pandas as pd
import pytest

from frictionbench.reports.studies.neighbours import where_answers_differ
from tests.helpers.studies import reduced, told


def test_neighbours_part_where_the_tip_leaves_and_by_the_order_of_hits() -> None:
    found = reduced(
        "neighbours",
        ensembles={
            "cases": ("rod at p < 0", "rod leaving at p < 0", "jam"),
            "schemes": ("anitescu_potra",),
            "solvers": ("lemke", "interior_point"),
            "sizes": (1e-8,),
        },
        landings={"schemes": ("anitescu_potra", "event_driven"), "spins": (1e-6, 1e-4)},
        lifts={"solvers": ("lemke", "interior_point"), "steps": (0.002,)},
    )
    ends = found["ensembles"].set_index(["case", "solver"])["apart"]
    assert ends["rod at p < 0", "lemke"] < 1e-7
    assert ends["rod leaving at p < 0", "lemke"] > 1e-3
    assert ends["rod leaving at p < 0", "interior_point"] > 1e-3
    landings = found["landings"].set_index(["scheme", "spin"])
    assert landings.loc[("event_driven", 1e-6), "after"] == pytest.approx(landings["closed"].iloc[0], rel=0.01)
    assert landings.loc[("anitescu_potra", 1e-6), "after"] < 1e-5
    account = told(found)
    assert account.answer.startswith("At edges, yes: neighbours part for good in ")
    assert "the solvers' answers differ in none;" in account.result


@pytest.mark.parametrize(
    ("differ", "several", "text"),
    [
        ([0, 0], [1, 0], "none"),
        ([1, 0], [1, 0], "1, all of these"),
        ([1, 0], [1, 1], "1, these only"),
        ([1, 1], [1, 0], "2, others, too"),
    ],
)
def test_where_answers_differ(differ, several, text) -> None:
    assert where_answers_differ(pd.Series(differ, dtype=bool), pd.Series(several, dtype=bool)) == text
