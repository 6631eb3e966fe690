"""Failure maps: a scene over a grid of two of its parameters, as plans make them and reports draw them.

A place on an axis counts grid lines from 0 at `low`; places between them are where a map was refined. Along a linear axis the
parameter grows by a term, along a logarithmic one by a factor; `zero` puts 0 before a logarithmic axis, and `both` mirrors one
about 0: -high ... -low, 0, low ... high. Next to 0 these two are linear.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any, Literal

from frictionbench.results.conventions import DEFAULT_SCHEME
from frictionbench.results.store import ResultsError

Scale = Literal["linear", "log", "zero", "both"]
Place = tuple[float, float]
DIGITS = 6  # of a parameter's value, but for powers of two: the same on every machine, and short in a table


@dataclass(frozen=True)
class Axis:
    """count: grid lines. whole: the parameter takes whole numbers only."""

    parameter: str
    low: float
    high: float
    count: int
    scale: Scale = "linear"
    whole: bool = False

    def value(self, place: float) -> float:
        """The parameter at a place; an int where the axis is whole."""
        exact = self._value(place)
        power = round(math.log2(abs(exact))) if exact else 0
        in_binary = math.isclose(abs(exact), 2.0**power, rel_tol=1e-12)  # units of which change no digit of a problem
        value = math.copysign(2.0**power, exact) if in_binary else float(f"{exact:.{DIGITS}g}")
        return round(value) if self.whole else value

    def _value(self, place: float) -> float:
        last = self.count - 1
        if self.scale == "linear":
            return self.low + (self.high - self.low) * place / max(last, 1)
        if self.scale == "log":
            return float(self.low * (self.high / self.low) ** (place / max(last, 1)))
        middle = last / 2 if self.scale == "both" else 0.0
        way = abs(place - middle)
        far = max(last - middle - 1, 1)
        size = self.low * way if way <= 1 else self.low * (self.high / self.low) ** ((way - 1) / far)
        return float(size if place >= middle else -size)


@dataclass(frozen=True)
class Map:
    """One map. parameters: the scene's others, fixed. name: of files and headings; title, note: what one is to see.

    scheme: whose first problem is met, or, in closed loop, who steps; steps: at most so many in closed loop, 0 for a map of
    first problems. levels: how often grid lines are halved, where neighbours' verdicts differ; most: new places each time.
    thresholds: names of problems.analysis.thresholds, drawn over the map. constant: nothing may change over the map.
    """

    name: str
    scene: str
    x: Axis
    y: Axis
    parameters: Mapping[str, Any] = field(default_factory=dict)
    scheme: str = DEFAULT_SCHEME
    steps: int = 0
    levels: int = 1
    most: int = 24
    thresholds: tuple[str, ...] = ()
    constant: bool = False
    title: str = ""
    note: str = ""

    @property
    def grid(self) -> list[Place]:
        """The places of the unrefined map."""
        return [(float(i), float(j)) for i, j in product(range(self.x.count), range(self.y.count))]

    def at(self, place: Place) -> dict[str, Any]:
        """The scene's parameters at a place."""
        return {**self.parameters, self.x.parameter: self.x.value(place[0]), self.y.parameter: self.y.value(place[1])}

    def places(self) -> Iterator[Place]:
        """Every place that the map can have, the coarser first."""
        for level in range(self.levels + 1):
            step = 0.5**level
            count = [int((axis.count - 1) / step) + 1 for axis in (self.x, self.y)]
            yield from ((i * step, j * step) for i, j in product(range(count[0]), range(count[1])))


def maps_of(manifest: Mapping[str, Any]) -> list[Map]:
    """The maps of a run, from its manifest. Errors: ResultsError where they cannot be read."""
    try:
        return [
            Map(**{**told, "x": Axis(**told["x"]), "y": Axis(**told["y"]), "thresholds": tuple(told["thresholds"])})
            for told in manifest["settings"].get("maps", [])
        ]
    except (KeyError, TypeError) as error:
        raise ResultsError(f"manifest.json: maps: cannot be read ({error})") from None


def thresholds_file(folder: Path, spec: Map) -> Path:
    """Where a run keeps the places at which theory changes its mind, by the threshold's name."""
    return folder / "maps" / f"{spec.name}.json"


def read_thresholds(folder: Path, spec: Map) -> dict[str, list[Place]]:
    """These places; none where they were not traced. Errors: ResultsError where the file cannot be read."""
    path = thresholds_file(folder, spec)
    if not path.exists():
        return {}
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        return {str(name): [(float(i), float(j)) for i, j in places] for name, places in told.items()}
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
