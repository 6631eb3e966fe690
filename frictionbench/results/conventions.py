"""What writers and readers of results call things: the values of the columns `scheme`, `start`, `phase` and `way`
(results.schema), the settings of batches, the two times by which solvers are ranked, and what a solver solves in place of
Coulomb's law, by which the verdict `relaxed` is split:

    another law   the convex relaxation, or soft contact: sliding contacts open, or rest contacts creep
    polygon       a polygon for the section of the friction cone in space: friction acts along few directions

The friction LCP of the plane is exact: its cone has two edges.
"""

import json
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.files import cleaned

if TYPE_CHECKING:  # the command line imports this file for its options
    import pandas as pd

DEFAULT_SCHEME = "anitescu_potra"  # of time stepping, where none is named
COLD, WARM, SHUFFLED = "cold", "warm", "shuffled"  # starts: zero; the impulses before; impulses drawn from the whole motion
APART = 1e-3  # of what contact changes: velocities whose distances from one reference differ by more are other outcomes

DRAWN = {"push": (0.2, 2.0), "friction": (0.2, 0.8), "mass_ratio": (1.0, 10.0)}  # of each problem of a batch, the bounds
NEARBY = 0.02  # by how much smaller the push is, in whose answers a batch starts warm
WAYS = {  # of solving all problems of a batch, with their meanings
    "calls": "a call of `solve` for each",
    "packed": "`solve_many` over a Batch, which is packed already",
    "list": "`solve_many` over a list of problems",
}


def first_phase(scheme: str) -> str:
    """The phase of the first problem that a scheme meets."""
    return "step" if scheme == DEFAULT_SCHEME else f"step of {scheme}"


class RankBy(StrEnum):
    """A time by which solvers are ranked. words: what a solver starts from; parts: of the time, in words.

    bodies   form + setup + solve: from the masses and contacts of the bodies, as a simulator has them
    form     setup + solve: from the form that the method takes, as one has it who assembles the Delassus matrix anyway
    """

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
        times = ["form_time", "setup_time", "solve_time"]
        return times[1:] if self is RankBy.FORM else times

    @property
    def other(self) -> "RankBy":
        return RankBy.BODIES if self is RankBy.FORM else RankBy.FORM

    def time(self, rows: "pd.DataFrame") -> "pd.Series[float]":
        """The time of each row, s; nan without a solve time."""
        return rows[self.columns[:-1]].fillna(0.0).sum(axis=1) + rows["solve_time"]


ANOTHER_LAW, POLYGON = "another law", "polygon"
MEANINGS = {
    ANOTHER_LAW: "solved within the tolerance for another law, the convex relaxation or soft contact; not for Coulomb's law",
    POLYGON: "solved within the tolerance with a polygon for the section of the friction cone; not with the cone",
}
# Every verdict with its meaning, in the order from the best to the worst, `relaxed` replaced by the two laws.
ENDINGS: dict[str, str] = {}
for _verdict in Verdict:
    ENDINGS |= MEANINGS if _verdict is Verdict.RELAXED else {str(_verdict): _verdict.meaning}


def law(model: str, dimension: float) -> str:
    """The law that a solver of this model solves in this dimension; empty for Coulomb's law."""
    if model == "lcp":
        return POLYGON if dimension == 3 else ""
    return "" if model == "coulomb" else ANOTHER_LAW


def ending(verdict: str, model: str) -> str:
    """The verdict on an answer of a solver of this model, `relaxed` replaced by ANOTHER_LAW or POLYGON."""
    if verdict != Verdict.RELAXED:
        return verdict
    return POLYGON if model == "lcp" else ANOTHER_LAW


def endings(rows: "pd.DataFrame") -> list[str]:
    """The ending of each row of the solves or the simulations table."""
    return [ending(*pair) for pair in zip(rows["verdict"], rows["model"], strict=True)]


def scene_title(scene: Any, parameters: Any) -> str:
    """A scene with its parameters in the notation of the command line: `stack[blocks=5]`."""
    settings = json_object(parameters)
    given = ",".join(f"{name}={value}" for name, value in settings.items())
    return f"{scene}[{given}]" if given else str(scene)


def count(number: int, noun: str) -> str:
    """The number with its noun: 1 problem, 12 problems."""
    return f"{number} {noun}{'s' * (number != 1)}"


def rough_percent(share: float) -> str:
    """Two digits of a share in percent, all of a hundred and more."""
    if 0 < abs(share) < 1e-4:
        return "<0.01 %"
    return f"{100 * share:.{'2g' if abs(share) < 0.995 else '0f'}} %"


def json_object(text: Any) -> dict[str, Any]:
    """The object in a text of JSON; empty where there is none."""
    try:
        found = cleaned(json.loads(text)) if isinstance(text, str) else {}
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
