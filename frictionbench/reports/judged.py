"""The judged steps of an engine as the page and the command line show them: percentiles, laws and solvers in numbers, and in
sentences whether contacts creep, why probably, and which forces can be compared.
"""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import Verdict
from frictionbench.reports.drawing.text import rough_percent
from frictionbench.results.conventions import RankBy, count, number
from frictionbench.results.judgement import LAWS, Judgement, read_judgements
from frictionbench.results.store import read_table

# The quantities whose percentiles are shown, with their units.
QUANTITIES = {"residual": "", **dict.fromkeys((*LAWS, "creep"), "m/s"), "penetration": "m"}
ENERGIES = {"energy_added": 1.0, "energy_lost": -1.0}  # J, by the sign of their energy defects
CREEP = 1e-4  # relative to the free velocity: contacts that slip less stick. Of g h in steps of 5 ms it is 0.005 mm/s
# Softness is the likely cause of creep if the ratio of its share of the impulse to the creep's share of the free velocity is
# larger. MuJoCo's boxes on a slope have 0.2 or more with a converged solver, 0.01 to 0.03 after 3 iterations of PGS or 2 of CG.
SOFT = 0.1
CHOSEN_FROM = 2  # a table's steps are chosen from this many times as many with the largest residuals
SAME_NET_IMPULSE = 0.01  # relative difference of net impulses below which they count as the same
SYMPTOM = "See 'An object at rest creeps' in docs/symptoms.md (What users of engines ask)."
HARDER = (
    "It is the likely cause: make contacts harder, in MuJoCo by solimp nearer 1, a larger impratio or, with "
    f"elliptic cones, noslip_iterations, in Drake by a smaller penetration allowance and stiction tolerance. {SYMPTOM}"
)
TIGHTER = (
    "The likely cause is a solver that stops early, or friction that the engine regularises: tighten its tolerance, raise its "
    f"number of iterations, or lower the speed at which friction is full. {SYMPTOM}"
)
WORSE_THAN_NONE = (
    "In most steps the impulses are worse than none, with residuals above 1: `impulse` is force times step, N s, the normal "
    "first and positive where bodies are pushed apart, and problem.velocity(impulse) is the engine's next velocity."
)
PERCENTILES = {"p50": 50, "p90": 90, "p99": 99, "worst": 100}


def percentiles(values: Iterable[float]) -> dict[str, float] | None:
    """Return PERCENTILES of the numbers by their names, or None without numbers."""
    known = list(values)
    return {name: float(np.percentile(known, p, method="higher")) for name, p in PERCENTILES.items()} if known else None


@dataclass(frozen=True)
class Judged:
    """A judged folder: its steps, and the rows of `solves` with the sum of form, setup and solve as `time`, s."""

    steps: list[Judgement]
    rows: pd.DataFrame

    @property
    def touching(self) -> list[Judgement]:
        """The steps that have a contact."""
        return [one for one in self.steps if one.contacts]

    @property
    def laws(self) -> dict[str, int]:
        """The number of steps with contacts in which each law, the most frequent first, or none is violated most."""
        violated = Counter(one.law for one in self.touching if one.residual > one.floor)
        none = len(self.touching) - violated.total()
        return dict(violated.most_common()) | ({"none beyond rounding": none} if none else {})

    @property
    def notes(self) -> dict[str, tuple[float, int]]:
        """For each note of a share above 0 its mean over the loaded steps that have it, and their number; the largest first."""
        shares = pd.DataFrame([one.notes for one in self.steps if not one.unloaded])
        means = shares.mean().sort_values(ascending=False, kind="stable")
        return {str(name): (float(mean), int(shares[name].count())) for name, mean in means.items() if mean}

    @property
    def percentiles(self) -> dict[str, dict[str, float] | None]:
        """The percentiles of the quantities over the steps with contacts, with 0 for energy of the other sign; None if no value
        is known."""
        values = {name: [one.known(name) for one in self.touching] for name in (*QUANTITIES, "energy_defect")}
        defects = [each or 0.0 for each in values.pop("energy_defect")]
        values |= {name: [max(0.0, sign * each) for each in defects] for name, sign in ENERGIES.items()}
        return {name: percentiles(value for value in known if value is not None) for name, known in values.items()}

    @property
    def impossible(self) -> str:
        """A sentence on the steps that are proved to have no solution, with the first of them; empty if there are none."""
        proved = [one for one in self.steps if one.contradiction]
        text = f"{len(proved)} of {len(self.steps)} steps {'has' if len(proved) == 1 else 'have'} no solution, with proof; "
        return text + f"{proved[0].file}: {proved[0].contradiction}" if proved else ""

    @property
    def doubts(self) -> str:
        """Sentences on what the files seem to lack or to hold in other units; empty if nothing is in doubt."""
        unknown, of = sum(one.penetration is None for one in self.touching), len(self.touching)
        text = f"{unknown} of {of} steps do not say their length `step`: penetration counts as a violation. " if unknown else ""
        return text + (WORSE_THAN_NONE if 2 * sum(one.residual > 1 for one in self.touching) > of else "")

    @property
    def creep(self) -> str:
        """Sentences on whether and how fast sticking contacts creep, and the likely cause; empty if none should stick.

        Speed and cause are those of the median step: the fastest may be an impact, whose cause is another.
        """
        held = sorted((one for one in self.steps if one.creep is not None), key=lambda one: one.known("creep") or 0.0)
        if not held:
            return ""
        shown = middle, fastest = held[len(held) // 2], held[-1]
        speeds = [one.known("creep") or 0.0 for one in shown]
        shares = [(one.creep or 0.0) / one.free_velocity if one.free_velocity else math.inf for one in shown]
        slip, largest = (f"{number(1e3 * v, 2)} mm/s, {rough_percent(share)}" for v, share in zip(speeds, shares, strict=True))
        creeps = speeds[0] > CREEP * middle.free_velocity
        how = "creep at" if creeps else "do, but for a creep of"
        text = f"Contacts that should stick {how} {slip} of the velocity that they would have without impulses, "
        several = f"in the median of {len(held)} of {len(self.touching)} steps; at up to {largest}, " * (len(held) > 1)
        text += f"{several}in {fastest.file}."
        if not creeps or WORSE_THAN_NONE in self.doubts:
            jerks = sum((one.known("creep") or 0.0) > CREEP * one.free_velocity for one in held)
            return text + f" In {jerks} of them they creep by more than {rough_percent(CREEP)} of it." * (jerks > 1 > creeps)
        soft = middle.notes.get("softness of contacts", 0.0)
        if soft * middle.free_velocity > SOFT * speeds[0]:
            where = "In the median step the" if len(held) > 1 else "The"
            return f"{text} {where} softness of contacts takes {rough_percent(soft)} of the impulse. {HARDER}"
        return f"{text} {TIGHTER}"

    @property
    def forces(self) -> str:
        """Sentences on the distances of net impulses from the exact answer's, and on which single forces are comparable."""
        nets = [(net, name, one.file) for one in self.steps if not one.unloaded for name, net in one.net_impulses.items()]
        known = [each for each in nets if each[0].determined]
        unloaded, of = sum(one.unloaded for one in self.touching), len(known)
        text = f"Left out: {count(unloaded, 'step')} without impulses beyond rounding. " if unloaded else ""
        if of < len(nets):
            text += f"{len(nets) - of} of {len(nets)} net impulses between bodies are not determined by the motion. "
        if known:
            near, same = sum(net.difference <= SAME_NET_IMPULSE for net, *_ in known), rough_percent(SAME_NET_IMPULSE)
            creep = sum(net.difference > SAME_NET_IMPULSE >= net.without_creep for net, *_ in known)
            most, name, file = max((net.without_creep if creep else net.difference, name, file) for net, name, file in known)
            text += f"Net impulses between bodies within {same} of the exact answer's: {near} of {of}. The "
            half = rough_percent(sorted(net.difference for net, *_ in known)[of // 2])
            text += f"difference is {half}" + " in the median" * (of > 1)
            if creep:
                rest = rough_percent(sorted(net.without_creep for net, *_ in known)[of // 2])
                text += f". Without the impulse that stops the creep the rest is {rest}, within {same} for {creep} more"
            text += f"; at most {rough_percent(most)}, in {file} (velocities: {name}). "
        if hyperstatic := sum(not net.each_determined for net, *_ in nets):
            text += f"In {hyperstatic} of {len(nets)} the forces of single contacts are not determined (hyperstatic)."
        return text.strip()

    def worst(self, most: int) -> list[Judgement]:
        """Return `most` steps with large residuals, beyond rounding, the largest first. Of the CHOSEN_FROM * most largest,
        those that exceed both their neighbours in time are preferred."""
        size = [one.residual if one.residual > one.floor else 0.0 for one in self.steps]
        largest = sorted((k for k in range(len(size)) if size[k]), key=lambda k: -size[k])[: CHOSEN_FROM * most]
        peaks = {k for k in largest if max(size[:k][-1:], default=0.0) < size[k] >= max(size[k + 1 :][:1], default=0.0)}
        return [self.steps[k] for k in sorted(sorted(largest, key=lambda k: k not in peaks)[:most], key=largest.index)]

    @property
    def beside(self) -> list[dict[str, Any]]:
        """Each solver's results on the steps with contacts: variant, solved, steps, percentiles of residual and of time, s.

        Steps in which the zero impulse is an answer too exact to be told from the solver's are left out.
        """
        each = pd.DataFrame({"problem": [one.problem for one in self.touching]}).merge(self.rows)  # equal steps share a problem
        each = each[~(each["trivial"] & (each["verdict"] == Verdict.UNJUDGEABLE))]
        return [
            {
                "variant": str(variant),
                "solved": int((rows["verdict"] == Verdict.SOLVED).sum()),
                "steps": len(rows),
                "residual": percentiles(filter(np.isfinite, rows["residual"])),
                "time": percentiles(filter(np.isfinite, rows["time"])),
            }
            for variant, rows in each.groupby("variant", sort=False)
        ]


def read_judged(folder: Path) -> Judged:
    """Read a judged folder. Errors: ResultsError if it holds no judgement, or a file cannot be read."""
    rows = read_table(folder, "solves")
    return Judged(read_judgements(folder), rows.assign(time=RankBy.BODIES.time(rows)))
