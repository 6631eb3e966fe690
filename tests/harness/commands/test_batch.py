"""The page on rates of many problems: what it refuses to show."""

import numpy as np
import pytest

from frictionbench.harness.commands.batch import Case, Rate, make_case, refusal, table

CASE = Case(4, (), active=0.9, idle=0.1)
RATE = Rate("lemke, packed", 5.0, 1.0, (0.1, 0.2, 0.3), 1.9)


@pytest.mark.parametrize(
    ("case", "rate", "why"),
    [
        (CASE, RATE, ""),
        (Case(0, (), 0.0, 0.0), RATE, "no contacts"),
        (Case(4, (), 0.9, 1.0), RATE, "friction is idle"),
        (Case(4, (), 0.0, 0.1), RATE, "friction is idle"),
        (CASE, Rate("osqp, single calls", 9.0, 0.25), "25 % verified"),
    ],
)
def test_rates_that_say_nothing_are_refused(case: Case, rate: Rate, why: str) -> None:
    assert refusal(case, rate).startswith(why)
    assert bool(refusal(case, rate)) == bool(why)
    shown = table(case, [rate])
    assert (f"| {rate.ratio:.2g} |" in shown) == (not why)


def test_cases_are_the_same_each_time() -> None:
    one, other = make_case(2, 3), make_case(2, 3)
    assert [problem.hash for problem in one.problems] == [problem.hash for problem in other.problems]
    assert len({problem.hash for problem in one.problems}) == 3
    assert np.isclose(one.active, 1.0)
