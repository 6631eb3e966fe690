"""Event-driven or time stepping? Errors against work, and where the event-driven scheme cannot go on."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from frictionbench.harness.studies.motions import FINEST, SAMPLES, by_events, exact, sampled
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems.check import Array
from frictionbench.problems.scenes import scene
from frictionbench.problems.schemes import SCHEMES, NoSolution, start
from frictionbench.problems.schemes.event_driven import newton
from frictionbench.problems.schemes.impact import impact
from frictionbench.results.store import Row

CASES: dict[str, tuple[str, dict[str, Any], float]] = {  # scene, parameters and duration, s
    "bouncing_ball": ("bouncing_ball", {"restitution": 0.5}, 1.2),
    "rocking_block": ("rocking_block", {}, 1.5),
    "sliding_rod": ("painleve_rod", {"friction": 0.5}, 1.0),
    "impacting_rod": ("painleve_rod", {"friction": 0.5, "lift": 0.1}, 0.8),
    "slider_crank": ("slider_crank_angles", {}, 0.02),
    "woodpecker": ("woodpecker", {}, 0.15),
}
NEWTON = ("moreau", "moreau_euler", "paoli_schatzman")  # schemes with Newton's law of restitution; the others have Poisson's
ENDS: tuple[tuple[str, dict[str, Any], float], ...] = (
    ("bouncing_ball", {"restitution": 0.5}, 2.0),
    ("rocking_block", {}, 8.0),
    ("painleve_rod", {"friction": 0.5}, 1.0),
    ("painleve_rod", {"friction": 0.5, "lift": 0.1}, 0.8),
    ("painleve_rod", {}, 0.2),
    ("painleve_rod", {"spin": 4.0, "tip_velocity": -3.0}, 0.2),
    ("slider_crank_angles", {}, 0.04),
    ("woodpecker", {}, 0.3),
    *((f"example_{number}", {}, 1.0) for number in range(1, 8)),
)


def errors(
    names: Iterable[str] = tuple(CASES),
    counts: Iterable[int] = (50, 100, 200, 400, 800),
    accuracies: Iterable[float] = (1e-5, 1e-7, 1e-9),
) -> Iterator[Row]:
    """Motions by every scheme that takes the scene, compared at ten times with the finest event-driven one of the same law."""
    for name in names:
        place, settings, duration = CASES[name]
        whole = scene(place, **settings, step=duration / SAMPLES)
        known = {law: sampled(whole, by_events(law, FINEST))[0] for law in (impact, newton)}
        for accuracy in accuracies:
            path, work = sampled(whole, by_events(impact, accuracy))
            yield {"scene": name, "scheme": "event_driven", "setting": accuracy, **compared(path, known[impact], work)}
        for label, scheme in SCHEMES.items():
            if scheme.events or scheme.refuses(whole):
                continue
            for count in counts:
                path, work = sampled(replace(whole, step=duration / count), scheme, count // SAMPLES)
                law = newton if label in NEWTON else impact
                yield {"scene": name, "scheme": label, "setting": duration / count, **compared(path, known[law], work)}


def ends(cases: Iterable[tuple[str, dict[str, Any], float]] = ENDS) -> Iterator[Row]:
    """How far the event-driven scheme comes, and why no farther."""
    for name, settings, duration in cases:
        made, reason = scene(name, **settings, step=duration / SAMPLES), ""
        now, kinds = start(made), []
        try:
            for _ in range(SAMPLES):
                now = SCHEMES["event_driven"](made, now, exact)
                kinds += [event.kind for event in now.events]
        except NoSolution as finding:
            reason = str(finding)
        counts = {"impacts": kinds.count("impact"), "accumulations": kinds.count("accumulation"), "events": len(kinds)}
        facts = {"scene": name, "parameters": json.dumps(settings), "duration": duration, "reached": now.time}
        yield facts | counts | {"reason": reason}


def compared(path: Array, known: Array, work: int) -> Row:
    """The largest error of a coordinate; none where the motion is not whole."""
    whole = len(path) == len(known)
    return {"error": float(np.abs(path - known).max()) if whole else None, "work": work}


STUDY = Study(
    name="events",
    question="Event-driven or time stepping?",
    method="""Six scenes with stick, slip, lift and impacts are followed by every scheme that takes them, with steps from a
    fiftieth to an 800th of the motion, and by the event-driven scheme with three accuracies of its integrator. The error is the
    largest of a coordinate at ten times, from the event-driven motion of accuracy 1e-11 with the same law of restitution; the
    work is the number of friction problems and, between events, of evaluations of the forces. The event-driven scheme then
    follows these scenes, four for longer, Painlevé's rod where forces alone cannot stop it, and the seven examples for 1 s,
    each in ten steps; where it ends it says why.""",
    tables=(
        Table(
            errors,
            {
                "scene": "scene",
                "scheme": "scheme",
                "setting": "step, s; of the event-driven scheme the integrator's relative accuracy",
                "error": "the largest error of a coordinate, m or rad; none where the scheme has no solution",
                "work": "friction problems and evaluations of forces",
            },
        ),
        Table(
            ends,
            {
                "scene": "scene",
                "parameters": "its settings, JSON",
                "duration": "planned, s",
                "reached": "the last of ten times that was reached, s",
                "impacts": "located impacts",
                "accumulations": "accumulation points that were continued past",
                "events": "all located events",
                "reason": "why it ended before, if it did",
            },
        ),
    ),
)
