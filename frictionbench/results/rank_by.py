"""The two times by which solvers are ranked.

bodies   form + setup + solve: from the masses and contacts of the bodies, as a simulator has them
form     setup + solve: from the form that the method takes, as one has it who assembles the Delassus matrix anyway
"""

from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the command line imports this file for its options
    import pandas as pd


class RankBy(StrEnum):
    """A ranking. words: what a solver starts from; parts: of the time, in words."""

    words: str
    parts: str

    def __new__(cls, value: str, words: str, parts: str) -> "RankBy":
        member = str.__new__(cls, value)
        member._value_ = value
        member.words, member.parts = words, parts
        return member

    BODIES = "bodies", "from bodies", "form, setup and solve"
    FORM = "form", "from the method's own form", "setup and solve"

    @property
    def columns(self) -> list[str]:
        """The columns of the solves table that add up to the time."""
        return ["form_time", "setup_time", "solve_time"][self is RankBy.FORM :]

    @property
    def other(self) -> "RankBy":
        return RankBy.BODIES if self is RankBy.FORM else RankBy.FORM

    def time(self, rows: "pd.DataFrame") -> "pd.Series[float]":
        """The time of each row, s; nan without a solve time."""
        return rows[self.columns[:-1]].fillna(0.0).sum(axis=1) + rows["solve_time"]
