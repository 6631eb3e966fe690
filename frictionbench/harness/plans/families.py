"""The problems of a first comparison, by family and size: in each of them friction is at work.

A family is a scene or an instance. It has two problems in each band of sizes that it reaches (1, 2 to 10, 11 to 100 and more
contacts), so that no family counts more than another: where it can, one in which contacts stick, held by friction alone, and
one in which they slide, or are hit. Motions (`recorded`) give as many steps each.

They stand in families.txt, a paragraph for each band, first those of the plane, then those in space: a line has both problems
of a family. The disc in a jam is against a wall that it hits, where friction must act; between two that it only touches no
impulse is an answer.
"""

from pathlib import Path
from typing import Any

from frictionbench.harness.plans.plan import Source
from frictionbench.problems.spec import parse

Band = dict[str, tuple[dict[str, Any], dict[str, Any]]]  # two problems of each family
STEEP = {"push": 0.0, "slope": 0.3}  # on a slope, where friction holds: contacts stick, and tall piles tip over
HIT = {"push": 0.0, "shear": 0.2, "fall": 1.0}


def _band(paragraph: str) -> Band:
    found: Band = {}
    for line in paragraph.splitlines():
        (name, first), (_, second) = (parse("scene", spec) for spec in line.split())
        found[name] = first, second
    return found


ONE, SMALL, MEDIUM, LARGE, SPACE_ONE, SPACE_SMALL, SPACE_MEDIUM, SPACE_LARGE = map(
    _band, Path(__file__).with_name("families.txt").read_text(encoding="utf-8").split("\n\n")
)
PLANE = (ONE, SMALL, MEDIUM, LARGE)
SPACE = (SPACE_ONE, SPACE_SMALL, SPACE_MEDIUM, SPACE_LARGE)


def sources(*bands: Band) -> tuple[Source, ...]:
    """The problems of these bands."""
    return tuple(Source(name, settings) for band in bands for name, both in band.items() for settings in both)


def halves(*bands: Band) -> tuple[Source, ...]:
    """One problem of each family in these bands, in turn the first and the second."""
    return tuple(Source(name, both[i % 2]) for band in bands for i, (name, both) in enumerate(band.items()))
