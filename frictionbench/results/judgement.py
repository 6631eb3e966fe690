"""Judgements of the steps of an engine, stored in DIR/judgement.json.

The exact solvers' answers to the same problems are rows of the table solves, by the problem's hash.
"""

import json
import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
from pydantic import Field, FiniteFloat

from frictionbench.problems.verdicts import Verdict
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
SOFT = 0.01  # share of the impulse from which on softness explains a creep
NEAR = 0.01  # relative difference of net impulses below which they count as the same
SYMPTOM = "See 'An object at rest creeps' in docs/symptoms.md."
PERCENTILES = (50, 90, 99, 100)


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


def write_judgements(folder: Path, found: list[Judgement]) -> None:
    write_text(folder / NAME, json.dumps([one._asdict() for one in found]))


def read_judgements(folder: Path) -> list[Judgement]:
    """The judgements. Errors: ResultsError naming the file where it is missing or cannot be read."""
    path = folder / NAME
    try:
        return read_parsed(path, list[Judgement])
    except FileNotFoundError:
        raise ResultsError(f"{path}: no steps were judged in this folder") from None


def touching(found: list[Judgement]) -> list[Judgement]:
    """The steps that have a contact."""
    return [one for one in found if one.contacts]


def percentiles(values: Iterable[float]) -> list[float] | None:
    """PERCENTILES of the numbers; None of none."""
    known = list(values)
    return [float(np.percentile(known, p, method="higher")) for p in PERCENTILES] if known else None


def laws(found: list[Judgement]) -> dict[str, int]:
    """In how many steps each law is the one violated most, the most frequent first."""
    return dict(Counter(one.law for one in touching(found) if one.residual > one.floor).most_common())


def notes(found: list[Judgement]) -> dict[str, tuple[float, int]]:
    """By note its mean share over the steps that have it, and their number; the largest first."""
    shares: dict[str, list[float]] = {}
    for one in found:
        for name, share in one.notes.items():
            shares.setdefault(name, []).append(share)
    mean = {name: (float(np.mean(own)), len(own)) for name, own in shares.items()}
    return dict(sorted(mean.items(), key=lambda item: -item[1][0]))


def impossible(found: list[Judgement]) -> str:
    """How many steps are proved to have no solution, with the first of them; empty for none."""
    proved = [one for one in found if one.contradiction]
    told = f"{len(proved)} of {len(found)} steps {'has' if len(proved) == 1 else 'have'} no solution, with proof; "
    return told + f"{proved[0].file}: {proved[0].contradiction}" if proved else ""


def creeping(found: list[Judgement]) -> str:
    """Whether contacts that should stick creep, how fast, and why most likely; empty where none should stick."""
    held = [one for one in found if one.creep is not None]
    if not held:
        return ""
    fastest = max(held, key=lambda one: one.creep or 0.0)
    speed, free = fastest.creep or 0.0, fastest.free_velocity
    if speed <= NO_CREEP * free:
        return f"Contacts that should stick do not creep, in {steps(len(held))}."
    told = f"Contacts that should stick creep at up to {1e3 * speed:.2g} mm/s ({fastest.file}), "
    told += f"{100 * speed / free:.2g} % of the velocity that they would have without impulses. "
    soft, _ = notes(found).get("softness of contacts", (0.0, 0))
    if soft > SOFT:
        return told + (
            f"{100 * soft:.2g} % of the impulse is the softness of the engine's contacts, which is the likely cause: make them "
            "harder, in MuJoCo by solimp nearer 1, a larger impratio or noslip_iterations, in Drake by a smaller penetration "
            f"allowance and stiction tolerance. {SYMPTOM}"
        )
    return told + (
        "The likely cause is a solver that stops early, or friction that the engine regularises: tighten its tolerance, raise "
        f"its number of iterations, or lower the speed at which friction is full. {SYMPTOM}"
    )


def forces_right(found: list[Judgement]) -> str:
    """How far the net impulses between bodies are from the exact answer's, and which contacts' own forces can be compared."""
    nets = [(one, name, net) for one in found for name, net in one.bodies.items()]
    determined = [each for each in nets if each[2][1]]
    if not nets:
        return ""
    told = f"{len(nets) - len(determined)} of {len(nets)} net impulses between bodies are not determined by the motion. "
    told = told if len(determined) < len(nets) else ""
    if determined:
        near = sum(net[3] <= NEAR for _, _, net in determined)
        one, name, net = max(determined, key=lambda each: each[2][3])
        told += f"{near} of {len(determined)} net impulses between bodies are within {100 * NEAR:g} % of the exact answer's; "
        told += f"farthest, by {100 * net[3]:.2g} %, are those on the velocities {name} in {one.file}. "
    if hyperstatic := sum(not net[2] for _, _, net in nets):
        told += f"In {hyperstatic} of {len(nets)} the forces of single contacts are not determined (hyperstatic)."
    return told.strip()


def steps(count: int) -> str:
    return f"{count} step{'' if count == 1 else 's'}"


def worst(found: list[Judgement], most: int) -> list[Judgement]:
    """The steps with the largest residuals that are not neighbours in time, the largest first."""
    order = {one.file: place for place, one in enumerate(found)}
    apart = len(found) // (2 * most)
    chosen: list[Judgement] = []
    for one in sorted(touching(found), key=lambda one: -one.residual):
        if len(chosen) < most and all(abs(order[one.file] - order[other.file]) >= apart for other in chosen):
            chosen.append(one)
    return chosen


def beside(rows: pd.DataFrame) -> list[dict[str, Any]]:
    """The solvers on the same steps, in the order of their rows: variant, problems solved of how many, and percentiles of
    residual and of time, s."""
    return [
        {
            "variant": str(variant),
            "solved": int((own["verdict"] == Verdict.SOLVED).sum()),
            "problems": len(own),
            "residual": percentiles(filter(np.isfinite, own["residual"])),
            "time": percentiles(filter(np.isfinite, own["time"])),
        }
        for variant, own in rows.groupby("variant", sort=False)
    ]


class Judged(NamedTuple):
    """A judged folder: the steps, those with contacts, the rows of solves with the time, s, of form, setup and solve, and what
    the functions of this file tell. percentiles: by quantity, over the steps with contacts, of absolute values."""

    steps: list[Judgement]
    touching: list[Judgement]
    rows: pd.DataFrame
    creep: str
    forces: str
    impossible: str
    laws: dict[str, int]
    notes: dict[str, tuple[float, int]]
    percentiles: dict[str, list[float] | None]
    beside: list[dict[str, Any]]


def read_judged(folder: Path) -> Judged:
    """Errors: ResultsError where the folder holds no judgement, or a file that cannot be read."""
    found, rows = read_judgements(folder), read_table(folder, "solves")
    rows = rows.assign(time=rows[["form_time", "setup_time", "solve_time"]].sum(axis=1, min_count=1))
    counted = touching(found)
    values = {name: [getattr(one, name) for one in counted] for name in QUANTITIES}
    own = {name: percentiles(abs(value) for value in some if value is not None) for name, some in values.items()}
    told = creeping(found), forces_right(found), impossible(found), laws(found), notes(found)
    return Judged(found, counted, rows, *told, own, beside(rows))
