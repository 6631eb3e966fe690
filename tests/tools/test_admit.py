"""The suite `hard`: solutions are known, friction is at work, and the recorded methods fail."""

import json

import numpy as np
import pytest

from frictionbench.harness.plans.hard import ADMITTED, METHODS, TOL, table
from frictionbench.problems.analysis.labels import FACETS
from frictionbench.problems.analysis.thresholds import THRESHOLDS
from frictionbench.problems.catalogue import problem_of
from frictionbench.problems.residual import residual, residual_floor
from tools.admit import ANSWERS, FEWEST, admissible, families, fewest_contacts, kept_answer

ROWS = table(ADMITTED)
NAMES = [f"{row['scene']} {row['parameters']}" for row in ROWS]
SMALL = [row for row in ROWS if int(row["contacts"]) <= 30]


def failed(row: dict[str, str]) -> dict[str, str]:
    return dict(each.rsplit(" ", 1) for each in row["failed"].split(", "))


def test_every_problem_is_a_candidate_on_which_a_method_fails() -> None:
    candidates = [source for d in (2, 3) for family in families(d).values() for source in family]
    assert {f"{source.scene} {json.dumps(source.parameters, sort_keys=True)}" for source in candidates}.issuperset(NAMES)
    for row in ROWS:
        assert failed(row).keys() <= set(METHODS)
        assert failed(row)


@pytest.mark.parametrize("row", ROWS, ids=NAMES)
def test_a_solution_is_known(row) -> None:
    problem, answer = problem_of(row["scene"], **json.loads(row["parameters"])), kept_answer(row)
    if answer is not None:
        assert residual(problem, answer) <= TOL
        assert residual_floor(problem, answer) <= TOL
    else:
        assert problem.mechanical
        assert not problem.joint_bias.any()
        assert THRESHOLDS["gaps"](problem), "with polygons there is a solution"
        wider = problem.replace(friction=problem.friction / np.cos(np.pi / FACETS))  # the polygons contain the circles
        assert THRESHOLDS["pointed"](wider) is ("masses_1e8" not in row["parameters"]), "docs/hard.md"


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({}, True),
        ({"verdict": "timeout", "residual": None}, False),  # nothing fails: a timeout depends on the machine
        ({"idle": True}, False),
        ({"trivial": True}, False),
        ({"existence": ""}, False),  # no solution is known
        ({"existence": "none"}, False),
        ({"existence": "", "solved": True}, True),
        ({"residual_floor": 2e-9}, False),  # rounding does not allow the tolerance
    ],
)
def test_admission(changed, expected) -> None:
    row = {"variant": "one", "problem": "a", "trivial": False, "idle": False, "existence": "gaps", "verdict": "unsolved"}
    row |= {"residual": 1e-3, "residual_floor": 1e-12} | changed
    other = row | {"variant": "two", "verdict": "solved", "residual": 1e-12}
    assert admissible([row, other] if "solved" in changed else [row]) == expected


def test_the_choice_takes_the_smallest_failures_of_each_method() -> None:
    def rows(contacts: int, **verdicts: str) -> list[dict[str, object]]:
        return [{"variant": name, "verdict": verdict, "contacts": contacts} for name, verdict in verdicts.items()]

    first = [rows(9 - k, one="unsolved", two="solved") for k in range(FEWEST + 1)]
    other = [rows(50, one="wrong", two="wrong"), rows(60, one="timeout", two="solved")]
    assert fewest_contacts([*first, *other]) == [*first[1:], other[0]]


def test_kept_answers_are_those_of_the_rows() -> None:
    with np.load(ANSWERS) as answers:
        assert set(answers.files) == {name for name, row in zip(NAMES, ROWS, strict=True) if row["answer"]}
