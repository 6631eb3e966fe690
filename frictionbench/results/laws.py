"""What a solver solves in place of Coulomb's law, by which the verdict `relaxed` is split.

    another law   the convex relaxation, or soft contact: sliding contacts open, or rest contacts creep
    polygon       a polygon for the section of the friction cone in space: friction acts along few directions

The friction LCP of the plane is exact: its cone has two edges.
"""

from typing import TYPE_CHECKING

from frictionbench.results.verdicts import Verdict

if TYPE_CHECKING:
    import pandas as pd

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
