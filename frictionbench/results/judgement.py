"""Judgements of the steps of an engine, stored in DIR/judgement.json.

The exact solvers' answers to the same problems are rows of the table `solves`, found by the problem's hash.
"""

import json
import math
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field, FiniteFloat

from frictionbench.results.files import ResultsError, read_parsed, write_text

FILE = "judgement.json"
LAWS = ("signorini", "cone", "direction", "dissipation")
Number = Annotated[float, Field(ge=-math.inf)]  # any but NaN


class NetImpulse(NamedTuple):
    """The net impulse of the contacts between two bodies.

    contacts: their number. determined: whether the motion determines their net impulse; each_determined: whether it determines
    that of each contact, which is not so if they are hyperstatic. difference: that of the engine's and the exact net impulse
    over the larger of the two, in the norm of the inverse mass; without_creep: the same with the impulse added that stops the
    creep. engine, exact: the net impulses, a number per velocity, of a free body force and moment times the step.
    """

    contacts: int
    determined: bool
    each_determined: bool
    difference: Number
    without_creep: Number
    engine: list[Number]
    exact: list[Number]


class Judgement(NamedTuple):
    """The judgement on one step of an engine.

    file: its name. problem: hash of the problem that it is judged by. contacts: their number.
    residual: that of the engine's impulses on the exact problem. floor: bound on the residual's rounding error.
    law: the law violated most at the contact with the largest residual. signorini, cone, direction, dissipation: the largest
    violation of each, m/s. creep: the largest slip at contacts that stick in the exact answer, m/s; None if none sticks or no
    exact answer is known. free_velocity: the largest velocity of a contact without impulses, m/s.
    net_impulses: between each two bodies in contact, by the indices of the bodies' velocities.
    penetration: at the beginning of the step, m; None if the step's length is unknown. energy_defect: J, by which the energy is
    above the balance of an exact answer. notes: effects that the problem does not express, with their shares of the impulse.
    forces: per contact |r_n|, |r_t| and mu r_n, N s. unloaded: there are no joints, and the engine's impulses are rounding
    and exact. contradiction: text, if the step is proved to have no solution.
    """

    file: str
    problem: str
    contacts: int
    residual: Number
    floor: Number
    law: Annotated[str, Field(pattern=f"^({'|'.join(LAWS)}|)$")]
    signorini: Number
    cone: Number
    direction: Number
    dissipation: Number
    creep: Number | None
    free_velocity: Number
    net_impulses: dict[str, NetImpulse]
    penetration: Number | None
    energy_defect: Number
    notes: dict[str, Number]
    forces: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]
    unloaded: bool
    contradiction: str

    def as_data(self) -> dict[str, Any]:
        """Return the judgement as plain values for JSON."""
        return self._asdict() | {"net_impulses": {name: net._asdict() for name, net in self.net_impulses.items()}}

    def known(self, name: str) -> float | None:
        """Return the quantity of this name, or 0 if it may be due to rounding."""
        value, rounding = getattr(self, name), self.floor * self.free_velocity
        if name == "energy_defect":
            rounding *= sum(abs(normal) + tangential for normal, tangential, _ in self.forces)
        return 0.0 if value is not None and name not in ("residual", "penetration") and abs(value) <= rounding else value


def write_judgements(folder: Path, judgements: list[Judgement]) -> None:
    write_text(folder / FILE, json.dumps([one.as_data() for one in judgements]))


def read_judgements(folder: Path) -> list[Judgement]:
    """Read the judgements. Errors: ResultsError naming the file if it is missing or cannot be read."""
    path = folder / FILE
    try:
        return read_parsed(path, list[Judgement])
    except FileNotFoundError:
        raise ResultsError(f"{path}: no steps were judged in this folder") from None
