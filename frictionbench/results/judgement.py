"""Judgements of the steps of an engine, stored in DIR/judgement.json.

The exact solvers' answers to the same problems are rows of the table solves, by the problem's hash.
"""

import json
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
from pydantic import Field, FiniteFloat

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.conventions import RankBy, count, rough_percent
from frictionbench.results.files import ResultsError, read_parsed, write_text
from frictionbench.results.store import read_table

NAME = "judgement.json"
LAWS = ("signorini", "cone", "direction", "dissipation")
Number = Annotated[float, Field(ge=-math.inf)]  # any but NaN
QUANTITIES = {  # what percentiles are shown of, with units
    "residual": "",
    "signorini": "m/s",
    "cone": "m/s",
    "direction": "m/s",
    "dissipation": "m/s",
    "creep": "m/s",
    "penetration": "m",
    "energy_defect": "J",
}
NO_CREEP = 1e-6  # of the free velocity: less is rounding
# Softness explains a creep where its share of the impulse is this part of the creep's share of the free velocity: MuJoCo
# has 0.2 and more for boxes on a slope if its solver converges, 0.01 to 0.03 if PGS ends after 3 iterations or CG after 2.
SOFT = 0.1
AMONG = 2  # times as many steps as a table shows are those that it is chosen from
NEAR = 0.01  # relative difference of net impulses below which they count as the same
SYMPTOM = "See 'An object at rest creeps' on the documentation's page 'What users of engines ask'."
HARDER = (
    "It is the likely cause: make contacts harder, in MuJoCo by solimp nearer 1, a larger impratio or noslip_iterations, in "
    f"Drake by a smaller penetration allowance and stiction tolerance. {SYMPTOM}"
)
TIGHTER = (
    "The likely cause is a solver that stops early, or friction that the engine regularises: tighten its tolerance, raise its "
    f"number of iterations, or lower the speed at which friction is full. {SYMPTOM}"
)
PERCENTILES = {"p50": 50, "p90": 90, "p99": 99, "worst": 100}


class Judgement(NamedTuple):
    """One step of an engine.

    file: its name. problem: hash of the problem by which it is judged. contacts: their number.
    residual: of the engine's impulses on the exact problem. floor: what rounding may change of it.
    law: which is violated most at the contact of the residual. signorini, cone, direction, dissipation: the largest violation
    of each, m/s. creep: m/s, the largest slip at contacts that stick in the exact answer; None where nothing sticks or no exact
    answer is known. free_velocity: m/s, the largest of a contact without impulses.
    bodies: of the contacts between two bodies, by the numbers of the bodies' velocities: how many they are; 1 where the motion
    determines their net impulse, and 1 where it determines each contact's, else 0 (hyperstatic); the difference of the engine's
    net impulse and the exact answer's over the larger, in the inverse mass; both, a number for each velocity: of a free body
    force and moment, times the step.
    penetration: m, with which the step begins; None where its length is unknown. energy_defect: J, what the
    answer adds to the balance of an exact one. notes: what the problem does not express, with its share of the impulse.
    forces: per contact |r_n|, |r_t| and mu r_n, N s. contradiction: in words, where the step is proved to have no solution.
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
    bodies: dict[str, Annotated[list[Number], Field(min_length=4)]]
    penetration: Number | None
    energy_defect: Number
    notes: dict[str, Number]
    forces: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]
    contradiction: str

    def known(self, name: str) -> float | None:
        """The quantity of this name, 0 where it is no larger than rounding may make it."""
        value, least = getattr(self, name), self.floor * self.free_velocity
        if name == "energy_defect":
            least *= sum(abs(normal) + tangential for normal, tangential, _ in self.forces)
        return 0.0 if value is not None and name not in ("residual", "penetration") and abs(value) <= least else value


def write_judgements(folder: Path, found: list[Judgement]) -> None:
    write_text(folder / NAME, json.dumps([one._asdict() for one in found]))


def read_judgements(folder: Path) -> list[Judgement]:
    """The judgements. Errors: ResultsError naming the file where it is missing or cannot be read."""
    path = folder / NAME
    try:
        return read_parsed(path, list[Judgement])
    except FileNotFoundError:
        raise ResultsError(f"{path}: no steps were judged in this folder") from None


def percentiles(values: Iterable[float]) -> dict[str, float] | None:
    """PERCENTILES of the numbers by their names; None of none."""
    known = list(values)
    return {name: float(np.percentile(known, p, method="higher")) for name, p in PERCENTILES.items()} if known else None


@dataclass(frozen=True)
class Judged:
    """A judged folder: its steps, and the rows of solves with the time, s, of form, setup and solve."""

    steps: list[Judgement]
    rows: pd.DataFrame

    @property
    def touching(self) -> list[Judgement]:
        """The steps that have a contact."""
        return [one for one in self.steps if one.contacts]

    @property
    def laws(self) -> dict[str, int]:
        """In how many steps each law is the one violated most, the most frequent first."""
        return dict(Counter(one.law for one in self.touching if one.residual > one.floor).most_common())

    @property
    def notes(self) -> dict[str, tuple[float, int]]:
        """By note its mean share over the steps that have it, and their number; the largest first."""
        shares = pd.DataFrame([one.notes for one in self.steps])
        means = shares.mean().sort_values(ascending=False, kind="stable")
        return {str(name): (float(mean), int(shares[name].count())) for name, mean in means.items()}

    @property
    def percentiles(self) -> dict[str, dict[str, float] | None]:
        """Those of the quantities over the steps with contacts, of absolute values; None where none is known."""
        values = {name: [one.known(name) for one in self.touching] for name in QUANTITIES}
        return {name: percentiles(abs(value) for value in own if value is not None) for name, own in values.items()}

    @property
    def impossible(self) -> str:
        """How many steps are proved to have no solution, with the first of them; empty for none."""
        proved = [one for one in self.steps if one.contradiction]
        have = "has" if len(proved) == 1 else "have"
        told = f"{len(proved)} of {len(self.steps)} steps {have} no solution, with proof; "
        return told + f"{proved[0].file}: {proved[0].contradiction}" if proved else ""

    @property
    def creep(self) -> str:
        """Whether contacts that should stick creep, how fast, and why most likely; empty where none should stick."""
        held = [one for one in self.steps if one.creep is not None]
        if not held:
            return ""
        fastest = max(held, key=lambda one: one.creep or 0.0)
        speed, free = fastest.creep or 0.0, fastest.free_velocity
        if speed <= NO_CREEP * free:
            return f"Contacts that should stick do not creep, in {count(len(held), 'step')}."
        told = f"Contacts that should stick creep at up to {1e3 * speed:.2g} mm/s ({fastest.file}), "
        told += f"{rough_percent(speed / free)} of the velocity that they would have without impulses. "
        soft = fastest.notes.get("softness of contacts", 0.0)
        if soft > SOFT * speed / free:
            return told + f"{rough_percent(soft)} of the impulse is the softness of the engine's contacts. {HARDER}"
        return told + TIGHTER

    @property
    def forces(self) -> str:
        """How far net impulses between bodies are from the exact answer's, and which contacts' own forces can be compared."""
        nets = [(one, name, net) for one in self.steps for name, net in one.bodies.items()]
        determined = [each for each in nets if each[2][1]]
        if not nets:
            return ""
        told = f"{len(nets) - len(determined)} of {len(nets)} net impulses between bodies are not determined by the motion. "
        told = told if len(determined) < len(nets) else ""
        if determined:
            near = sum(net[3] <= NEAR for _, _, net in determined)
            one, name, net = max(determined, key=lambda each: each[2][3])
            told += f"{near} of {len(determined)} net impulses between bodies are within {rough_percent(NEAR)} of the exact "
            told += f"answer's; farthest, by {rough_percent(net[3])}, are those on the velocities {name} in {one.file}. "
        if hyperstatic := sum(not net[2] for _, _, net in nets):
            told += f"In {hyperstatic} of {len(nets)} the forces of single contacts are not determined (hyperstatic)."
        return told.strip()

    def worst(self, most: int) -> list[Judgement]:
        """So many steps with large residuals, beyond rounding, the largest first: of the AMONG * most largest those above both
        their neighbours in time, then the largest of the others."""
        size = [one.residual if one.residual > one.floor else 0.0 for one in self.steps]
        largest = sorted((k for k in range(len(size)) if size[k]), key=lambda k: -size[k])[: AMONG * most]
        peaks = {k for k in largest if max(size[:k][-1:], default=0.0) < size[k] >= max(size[k + 1 :][:1], default=0.0)}
        return [self.steps[k] for k in sorted(sorted(largest, key=lambda k: k not in peaks)[:most], key=largest.index)]

    @property
    def beside(self) -> list[dict[str, Any]]:
        """The solvers on the steps with contacts: variant, steps solved of how many, percentiles of residual and of time, s."""
        each = pd.DataFrame({"problem": [one.problem for one in self.touching]}).merge(self.rows)  # equal steps are one problem
        return [
            {
                "variant": str(variant),
                "solved": int((own["verdict"] == Verdict.SOLVED).sum()),
                "steps": len(own),
                "residual": percentiles(filter(np.isfinite, own["residual"])),
                "time": percentiles(filter(np.isfinite, own["time"])),
            }
            for variant, own in each.groupby("variant", sort=False)
        ]


def read_judged(folder: Path) -> Judged:
    """Errors: ResultsError where the folder holds no judgement, or a file that cannot be read."""
    rows = read_table(folder, "solves")
    return Judged(read_judgements(folder), rows.assign(time=RankBy.BODIES.time(rows)))
