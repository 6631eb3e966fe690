"""Labels of hardness: each holds on its side of its threshold, and none where a column was not measured."""

import numpy as np
import pandas as pd
import pytest

from frictionbench.results.hardness import hardness
from frictionbench.results.schema import SOLVES

PLANAR = {"contacts": 10, "dimension": 2, "velocities": 30}
SIDES = {  # for each label a row that has it and one that has not, by as little as the threshold tells apart
    "masses": ({"mass_ratio": 1e4}, {"mass_ratio": 9.9e3}),
    "friction": ({"largest_friction": 3.0}, {"largest_friction": 2.9}),
    "non-P0": ({"p0_margin": -0.5}, {"p0_margin": 0.5}),
    "near p = 0": ({"p0_margin": 0.01}, {"p0_margin": 0.011}),
    "jam": ({"pointedness": 2.0}, {"pointedness": 0.0}),
    "hyperstatic": ({**PLANAR, "redundancy": 5}, {**PLANAR, "redundancy": 4}),
    "ill-conditioned": ({"condition": 1e8}, {"condition": 9e7}),
    "sensitive": ({"sensitivity": float("inf")}, {"sensitivity": 9e3}),
    "several outcomes": ({"outcomes": 2}, {"outcomes": 1}),
    "unlike islands": ({"island_ratio": 1e3}, {"island_ratio": 9e2}),
    "large": ({"contacts": 100}, {"contacts": 99}),
}


def labels(row: dict[str, float]) -> list[str]:
    """Of a row of which nothing else was measured."""
    (found,) = hardness(pd.DataFrame([dict.fromkeys((column.name for column in SOLVES), np.nan) | row])).to_dict("records")
    return [label for label, holds in found.items() if holds]


@pytest.mark.parametrize("label", SIDES)
def test_threshold(label) -> None:
    inside, outside = SIDES[label]
    assert inside.keys() <= {column.name for column in SOLVES}
    assert label in labels(inside)
    assert label not in labels(outside)


def test_what_was_not_measured_gives_no_label_and_a_rank_is_bounded_by_the_velocities() -> None:
    assert labels({}) == []
    assert labels({"contacts": 80, "dimension": 2, "velocities": 120}) == ["hyperstatic"]
    assert labels({"contacts": 80, "dimension": 2, "velocities": 121}) == []
