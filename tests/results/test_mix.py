"""The mix of a run's problems, and the weights of families."""

import pandas as pd
import pytest

from frictionbench.results.mix import mix, weights


def problem(scene: str, contacts: int, sticking: float | None, sliding: float | None, dimension: int = 2, step: int = 0):
    opened = None if sticking is None or sliding is None else contacts - sticking - sliding
    facts = {"scene": scene, "parameters": "{}", "step": step, "phase": "step", "contacts": contacts, "dimension": dimension}
    return facts | {"sticking": sticking, "sliding": sliding, "open": opened}


ROWS = [
    problem("rod", 1, 0, 1),
    problem("rod", 1, 1, 0, step=1),
    problem("stack", 4, 1, 1, step=1),
    problem("stack", 10, 10, 0),
    problem("stack", 100, 50, 50, step=2),
    problem("wall", 20, 0, 20),
    problem("wall", 20, None, None, step=1),
    problem("cubes", 400, 100, 300, dimension=3),
]


def test_mix_by_dimension_and_size() -> None:
    found = mix(pd.DataFrame(ROWS * 2))  # two rows of each problem count once
    assert found["problems"].to_dict() == {(2, "1"): 2, (2, "2 to 10"): 2, (2, "11 to 100"): 3, (3, "over 100"): 1}
    assert found["scenes"].to_dict() == {(2, "1"): 1, (2, "2 to 10"): 1, (2, "11 to 100"): 2, (3, "over 100"): 1}
    assert found.loc[(2, "2 to 10"), ["sticking", "sliding", "open"]].tolist() == pytest.approx([0.625, 0.125, 0.25])
    assert found.loc[(2, "11 to 100"), ["sticking", "sliding", "open"]].tolist() == pytest.approx([0.25, 0.75, 0.0])


def test_families_of_one_size_weigh_the_same() -> None:
    problems = pd.DataFrame(ROWS)
    weighted = problems.assign(weight=weights(problems))
    assert weighted["weight"].tolist() == [0.5, 0.5, 0.5, 0.5, 1.0, 0.5, 0.5, 1.0]
