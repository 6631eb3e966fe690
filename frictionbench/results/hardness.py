"""What makes a problem hard, from the measured columns of its row: a set of labels, each with its threshold.

Labels state facts about a problem, not about any method. A column that was not measured (null) gives no label.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

ILL = 1e8  # condition of W on its range, at which a factorisation loses half of the digits of double precision
Row = Mapping[str, Any]


class Hardness(NamedTuple):
    """meaning: of the label, with its threshold and the reason for it. holds: whether a row has it."""

    meaning: str
    holds: Callable[[Row], bool]


def _value(row: Row, column: str) -> float:
    """A number of the row, NaN, with which no comparison holds, where it was not measured."""
    value = row.get(column)
    return np.nan if value is None else float(value)


def _hyperstatic(row: Row) -> bool:
    """Where the rank is unknown it is at most the number of velocities."""
    rows, redundancy = _value(row, "contacts") * _value(row, "dimension"), _value(row, "redundancy")
    known = rows - _value(row, "velocities") if np.isnan(redundancy) else redundancy
    return known >= rows / 4 > 0


HARDNESS = {
    "masses": Hardness(
        "effective masses at the contacts differ by 1e4 or more, about as many sweeps as a contact-wise method then needs",
        lambda row: _value(row, "mass_ratio") >= 1e4,
    ),
    "friction": Hardness(
        "some friction coefficient is 3 or more, above those of dry surfaces; the LCP's matrix is then far from semidefinite",
        lambda row: _value(row, "largest_friction") >= 3,
    ),
    "non-P0": Hardness(
        "the LCP of some contact alone is not P0 (p0_margin below 0): Painlevé's case, in which Newton's and least-index "
        "methods lose their guarantees",
        lambda row: _value(row, "p0_margin") < 0,
    ),
    "near p = 0": Hardness(
        "the least p0_margin is within 0.01 of 0: almost any normal impulse is consistent with sliding",
        lambda row: abs(_value(row, "p0_margin")) <= 1e-2,
    ),
    "jam": Hardness(
        "the friction cone is not pointed: contacts can press on one another without moving anything, so that impulses are not "
        "bounded by the data",
        lambda row: _value(row, "pointedness") > 1e-9,
    ),
    "hyperstatic": Hardness(
        "a quarter or more of the rows of W depend on the others: the impulses are far from unique",
        _hyperstatic,
    ),
    "ill-conditioned": Hardness(
        "the condition of W on its range is 1e8 or more: half of the digits",
        lambda row: _value(row, "condition") >= ILL,
    ),
    "sensitive": Hardness(
        "the velocities change 1e4 times as much as the data or more",
        lambda row: _value(row, "sensitivity") >= 1e4,
    ),
    "several outcomes": Hardness(
        "the solutions have two or more distinct velocities",
        lambda row: _value(row, "outcomes") >= 2,
    ),
    "unlike islands": Hardness(
        "the largest closing speeds of two islands of the contact graph differ by 1e3 or more",
        lambda row: _value(row, "islands") >= 2 and _value(row, "island_ratio") >= 1e3,
    ),
    "large": Hardness("100 contacts or more", lambda row: _value(row, "contacts") >= 100),
}


def hardness(row: Row) -> tuple[str, ...]:
    """The labels of a problem, in the order of HARDNESS, from a row of `solves` or any mapping with its columns."""
    return tuple(label for label, one in HARDNESS.items() if one.holds(row))
