"""The verdicts on a cell, ordered from the best to the worst."""

from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


class Verdict(StrEnum):
    """The result of verifying a cell, with its meaning, from the best to the worst. The last one, SKIPPED, is not measured.

    >>> import frictionbench as fb
    >>> fb.Verdict.SKIPPED.meaning, fb.Verdict("solved") is fb.Verdict.SOLVED
    ('not run, for the reason given', True)
    """

    meaning: str

    def __new__(cls, value: str, meaning: str) -> "Verdict":
        member = str.__new__(cls, value)
        member._value_ = value
        member.meaning = meaning
        return member

    SOLVED = "solved", "the residual of the exact problem is within the tolerance"
    RELAXED = "relaxed", "the model the solver was given is solved within the tolerance, the exact problem is not"
    NEAR_MISS = "near_miss", "claimed solved, and the residual, or that of the model, is below ten times the tolerance"
    UNJUDGEABLE = "unjudgeable", "claimed solved, but rounding, or a tolerance near the zero impulse's residual, leaves it open"
    UNSOLVED = "unsolved", "not claimed solved, and neither the exact problem nor the model is known to be solved"
    TIMEOUT = "timeout", "stopped at the time limit"
    CRASHED = "crashed", "the call raised an error or its process ended"
    WRONG = "wrong", "claimed solved, and the residuals of the problem and of the model are at least ten times the tolerance"
    SKIPPED = "skipped", "not run, for the reason given"


SINGLE = "single precision"  # the start of the reason for which a solver of single precision is skipped
RANK: dict[str, int] = {verdict: rank for rank, verdict in enumerate(Verdict)}  # 0 is the best
ACCEPTED = (Verdict.SOLVED, Verdict.RELAXED)  # the exact problem or the solver's own model is solved


def measured(rows: "pd.DataFrame") -> "pd.Series[bool]":
    """Which rows of a table belong to cells that were run."""
    return rows["verdict"] != Verdict.SKIPPED
