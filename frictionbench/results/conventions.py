"""Conventions shared by writers and readers of results: the values of the columns `scheme`, `start`, `phase` and `way`
(results.schema), the settings of batches, the two times by which solvers are ranked, and the two models that replace Coulomb's
law, by which the verdict `relaxed` is split:

    another law   the convex relaxation, or soft contact: sliding contacts open, or sticking contacts creep
    polygon       a polygonal section of the friction cone in space: friction acts along a few directions

In the plane the LCP is exact, since the cone has two edges.
"""

import json
import re
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.files import cleaned

if TYPE_CHECKING:  # the command line imports this file for its options
    import pandas as pd

ROBOT_STEP = "robot_step"  # the scene of recorded steps of robots; its parameter `case` begins with the model
DEFAULT_SCHEME = "anitescu_potra"  # the default time-stepping scheme
COLD, WARM, SHUFFLED = "cold", "warm", "shuffled"  # starts: zero; previous impulses; impulses drawn from the whole motion
ANOTHER_OUTCOME = 1e-3  # relative to the change by contact: velocities are different whose distances differ by more

DRAWN = {"push": (0.2, 2.0), "friction": (0.2, 0.8), "mass_ratio": (1.0, 10.0)}  # bounds of what is drawn for a batch
NEARBY = 0.02  # relative reduction of the push in the problems whose answers are a batch's warm start
WAYS = {  # the ways to solve all problems of a batch, with their meanings
    "calls": "a call of `solve` for each",
    "packed": "`solve_many` over a Batch, which is packed already",
    "list": "`solve_many` over a list of problems",
}

ANOTHER_LAW, POLYGON = "another law", "polygon"
MEANINGS = {
    ANOTHER_LAW: "solved within the tolerance for another law, the convex relaxation or soft contact; not for Coulomb's law",
    POLYGON: "solved within the tolerance with a polygon for the section of the friction cone; not with the cone",
}
# Every verdict with its meaning, from the best to the worst; ANOTHER_LAW and POLYGON replace `relaxed`.
ENDINGS: dict[str, str] = {}
for _verdict in Verdict:
    ENDINGS |= MEANINGS if _verdict is Verdict.RELAXED else {str(_verdict): _verdict.meaning}


def first_phase(scheme: str) -> str:
    """Return the phase of a scheme's first problem."""
    return "step" if scheme == DEFAULT_SCHEME else f"step of {scheme}"


class RankBy(StrEnum):
    """A time by which solvers are ranked. words: what a solver starts from, as text; parts: the parts of the time, as text.

    bodies   form + setup + solve: from the masses and contacts of the bodies, as in a simulator
    form     setup + solve: from the form that the method takes, for users who assemble the Delassus matrix anyway
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
        """Return the time of each row, s, at least a clock's resolution, as axes are logarithmic; NaN without a solve time."""
        return (rows[self.columns[:-1]].fillna(0.0).sum(axis=1) + rows["solve_time"]).clip(lower=1e-9)


def law(model: str, dimension: float) -> str:
    """Return the law that a solver of this model solves in this dimension, empty for Coulomb's law."""
    if model == "lcp":
        return POLYGON if dimension == 3 else ""
    return "" if model == "coulomb" else ANOTHER_LAW


def ending(verdict: str, model: str) -> str:
    """Return the verdict on an answer by a solver of this model, with `relaxed` replaced by ANOTHER_LAW or POLYGON."""
    return (POLYGON if model == "lcp" else ANOTHER_LAW) if verdict == Verdict.RELAXED else verdict


def endings(rows: "pd.DataFrame") -> list[str]:
    """Return the ending of each row of a table."""
    return [ending(*pair) for pair in zip(rows["verdict"], rows["model"], strict=True)]


def scene_title(scene: Any, parameters: Any) -> str:
    """Return a scene with its parameters in the notation of the command line: `stack[blocks=5]`."""
    settings = json_object(parameters)
    text = ",".join(f"{name}={value}" for name, value in settings.items())
    return f"{scene}[{text}]" if text else str(scene)


def count(number: int, noun: str) -> str:
    """Return the number with its noun: 1 problem, 12 problems."""
    return f"{number} {noun}{'s' * (number != 1)}"


def number(value: float, digits: int = 3) -> str:
    """Format a number with this many significant digits at most, and a short exponent if it has one: 316, 0.25, 3.16e-5."""
    if value == 0 or 1e-3 <= abs(value) < 10**digits - 0.5:
        return f"{value:.{digits}g}"
    return re.sub(r"\.?0*e(-?)\+?0*", r"e\1", f"{value:.{digits - 1}e}")


def json_object(text: Any) -> dict[str, Any]:
    """Return the object in a JSON text, empty if there is none."""
    try:
        value = cleaned(json.loads(text)) if isinstance(text, str) else {}
    except (ValueError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}
