"""Rates that say nothing are refused, with the reason; the others follow from the raw times."""

import pytest

from frictionbench.reports.batches import rate_of
from tests.helpers.made_results import batch_row


def test_a_rate_follows_from_the_fastest_round() -> None:
    found = rate_of(batch_row("lemke", "packed", times=[3e-3, 1e-3], base_times=[4e-3, 5e-3]))
    assert found == ["lemke", "packed", "cold", "1,000", "4"]


@pytest.mark.parametrize(
    ("facts", "why"),
    [
        ({"contacts": 0}, "no contacts"),
        ({"idle": 1.0}, "friction is idle in all problems"),
        ({"active": 0.0}, "friction is idle in all problems"),
        ({"verified": 0.9996, "verdict": "wrong"}, "99.9 % verified"),
        ({"verified": 0.0, "verdict": "relaxed"}, "0 % verified"),
        ({"residual": 1e-7}, "residual above the tolerance"),
        ({"verdict": "skipped", "verified": None, "reason": "osqp not installed"}, "skipped: osqp not installed"),
        ({"verdict": "timeout", "verified": None, "reason": ""}, "timeout"),
        ({"times": []}, "not timed"),
        ({"base_times": [float("nan")]}, "not timed"),
    ],
)
def test_rates_that_say_nothing_are_refused(facts: dict[str, object], why: str) -> None:
    found = rate_of(batch_row("lemke", "packed", **facts))
    assert found[3:] == [why, "–"]
