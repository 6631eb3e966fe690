"""Failure maps: a scene over a grid of two of its parameters. Plans define them and reports draw them.

A position on an axis is measured in grid lines, from 0 to count - 1; grid points between the lines come from refinement. The
scales are `linear`; `log`, logarithmic; `zero`, logarithmic with 0 as an additional line before `low`; and `both`, logarithmic
in both directions from 0: -high ... -low, 0, low ... high. The last two are linear between 0 and `low`.

    DIR/maps/NAME.json      thresholds traced from the mechanics

A solution is known to exist at a grid point if theory or the enumeration of all solutions proves it (column `existence`), or if
a solver's answer is verified. It is not known to exist if the enumeration finds none, even if an answer is accurate.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, NonNegativeInt

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.conventions import DEFAULT_SCHEME, first_phase, number
from frictionbench.results.files import parsed

if TYPE_CHECKING:
    import pandas as pd

Scale = Literal["linear", "log", "zero", "both"]
GridPoint = tuple[float, float]  # positions on the two axes
# Units of scenes' parameters; friction, ratios and numbers of bodies have none.
UNITS = {
    **dict.fromkeys(("angle", "tilt", "slope"), "rad"),
    **dict.fromkeys(("push", "speed", "fall", "pull", "drop", "velocity", "tip_velocity", "lift", "sideways"), "m/s"),
    **dict.fromkeys(("spin", "ripple"), "rad/s"),
    **dict.fromkeys(("overlap", "depth", "height", "radius", "length", "half_length", "clearance", "lean", "thickness"), "m"),
    **{"step": "s", "duration": "s", "shear": "1/s", "mass": "kg"},
}
MOST_POINTS = 10**6  # of the refined grid: far more than any suite has
THEORY = ("gaps", "pointed")  # proofs of existence that also hold for the same problem with fewer contacts
VALUE_DIGITS = 6  # significant digits of a parameter's value: few enough to be equal on all machines and short in a table


@dataclass(frozen=True)
class Axis:
    """One axis of a map. count: number of grid lines. whole: the parameter takes whole numbers only."""

    parameter: str
    low: float
    high: float
    count: NonNegativeInt
    scale: Scale = "linear"
    whole: bool = False

    def __post_init__(self) -> None:
        logarithmic = self.scale != "linear" and not min(self.low, self.high) > 0
        if logarithmic or not all(map(math.isfinite, map(self._value, (0, self.count - 1)))):
            raise ValueError(f"the axis {self.parameter} has no values")

    def value(self, position: float) -> float:
        """Return the parameter at a position: exact for powers of two, else to VALUE_DIGITS; an int if the axis is whole."""
        exact = self._value(position)
        power = round(math.log2(abs(exact))) if exact else 0
        is_power = math.isclose(abs(exact), 2.0**power, rel_tol=1e-12)  # scaling by a power of two changes no digit
        value = math.copysign(2.0**power, exact) if is_power else float(f"{exact:.{VALUE_DIGITS}g}")
        return round(value) if self.whole else value

    @property
    def name(self) -> str:
        """The parameter with its unit."""
        return f"{self.parameter}, {UNITS[self.parameter]}" if self.parameter in UNITS else self.parameter

    @property
    def extent(self) -> str:
        """The parameter from its first to its last value, with its unit: angle 0.4 to 1.4 rad."""
        low, high = (number(self.value(line)) for line in (0, self.count - 1))
        return f"{self.parameter} {low} to {high} {UNITS.get(self.parameter, '')}".rstrip()

    def _value(self, position: float) -> float:
        last = self.count - 1
        if self.scale == "linear":
            return self.low + (self.high - self.low) * position / max(last, 1)
        if self.scale == "log":
            return float(self.low * (self.high / self.low) ** (position / max(last, 1)))
        middle = last / 2 if self.scale == "both" else 0.0
        distance = abs(position - middle)
        steps = max(last - middle - 1, 1)
        size = self.low * distance if distance <= 1 else self.low * (self.high / self.low) ** ((distance - 1) / steps)
        return float(size if position >= middle else -size)


@dataclass(frozen=True)
class Map:
    """One map. parameters: the fixed values of the scene's other parameters. name: used for files and headings.

    steps: the largest number of steps in closed loop, or 0 for a map of the scene's first problems; scheme: the time-stepping
    scheme that makes these problems. refined: whether points are added midway between neighbouring grid points with different
    verdicts; most: the largest number of these. thresholds: names of theoretical thresholds drawn over the map. constant:
    whether verdicts and work must be the same over the whole map. title, note: text above the drawing.
    """

    name: Annotated[str, Field(pattern=r"^[\w-]+$")]
    scene: str
    x: Axis
    y: Axis
    parameters: dict[str, Any] = field(default_factory=dict)
    scheme: str = DEFAULT_SCHEME
    steps: NonNegativeInt = 0
    refined: bool = True
    most: NonNegativeInt = 24
    thresholds: tuple[str, ...] = ()
    constant: bool = False
    title: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        if 4 * self.x.count * self.y.count > MOST_POINTS:
            raise ValueError(f"more than {MOST_POINTS} grid points")

    @property
    def grid(self) -> list[GridPoint]:
        """The grid points of the unrefined map."""
        return [(float(i), float(j)) for i, j in product(range(self.x.count), range(self.y.count))]

    def at(self, point: GridPoint) -> dict[str, Any]:
        """The scene's parameters at a grid point."""
        return {**self.parameters, self.x.parameter: self.x.value(point[0]), self.y.parameter: self.y.value(point[1])}

    def grid_points(self) -> list[GridPoint]:
        """Return every grid point that the map can have, those of `grid` first, and repeated among the others."""
        halves = product(range(2 * self.x.count - 1), range(2 * self.y.count - 1)) if self.refined else ()
        return [*self.grid, *((i / 2, j / 2) for i, j in halves)]


def maps_of(manifest: Mapping[str, Any]) -> list[Map]:
    """Return the maps of a run, from its manifest. Errors: ResultsError if they cannot be read."""
    return parsed(manifest["settings"].get("maps", []), list[Map], "manifest.json: maps")


def thresholds_file(folder: Path, spec: Map) -> Path:
    """The file that holds the points on each threshold of a map by its name, if any was traced."""
    return folder / "maps" / f"{spec.name}.json"


def at_grid_points(rows: "pd.DataFrame", spec: Map) -> "pd.DataFrame":
    """Select the rows of a map to the tightest tolerance, from simulations for a map in closed loop and from solves otherwise.

    Added columns: i, j (the grid point), tile (width of its tile in grid lines) and known (whether a solution is known).
    """
    rows = rows[rows["scheme"] == spec.scheme] if spec.steps else rows[rows["phase"] == first_phase(spec.scheme)]
    rows = rows[(rows["scene"] == spec.scene) & (rows["tol"] == rows["tol"].min())]
    points: dict[str, tuple[float, float, float]] = {}
    for i, j in spec.grid_points():
        tile = 1.0 if i % 1 == 0 and j % 1 == 0 else 0.5
        points.setdefault(json.dumps(spec.at((i, j)), sort_keys=True), (i, j, tile))
    rows = rows[rows["parameters"].isin(points.keys())]
    row_points = [points[parameters] for parameters in rows["parameters"]]
    rows = rows.assign(**{name: [point[k] for point in row_points] for k, name in enumerate(("i", "j", "tile"))})
    solved = (rows["verdict"] == Verdict.SOLVED).groupby([rows["i"], rows["j"]]).transform("any")
    if spec.steps:
        return rows.assign(known=solved)
    return rows.assign(known=rows["existence"].isin([*THEORY, "counted"]) | (solved & (rows["existence"] != "none")))
