"""Event-driven or time stepping? Errors against work, and where the event-driven scheme cannot go on."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, NoSolution, impact, newton, start
from frictionbench.reports.drawing.figures import Panel
from studies.motions import REFERENCE_ACCURACY, SAMPLES, by_events, exact, sampled
from studies.orders import COMPARED, HIGHER
from studies.slider_crank import slider_crank_angles
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, listing, order, require

EVENTS = "event_driven"
LEAST_DRAWN = 1e-15  # errors below it are drawn there
CASES: dict[str, tuple[str, dict[str, Any], float]] = {  # scene, parameters and duration, s
    "bouncing_ball": ("bouncing_ball", {"restitution": 0.5}, 1.2),
    "bowl": ("bowl", {"friction": 0.3}, 1.2),
    "rocking_block": ("rocking_block", {}, 1.5),
    "sliding_rod": ("painleve_rod", {"friction": 0.5}, 1.0),
    "impacting_rod": ("painleve_rod", {"friction": 0.5, "lift": 0.1}, 0.8),
    "slider_crank": (slider_crank_angles.__name__, {}, 0.02),
    "woodpecker": ("woodpecker", {}, 0.15),
}
ONE_CONTACT = ("bouncing_ball", "bowl")  # scenes that the scheme of second order takes
NEWTON = ("moreau", "moreau_euler", "paoli_schatzman", HIGHER)  # of Newton's law of restitution; the others have Poisson's
ENDS: tuple[tuple[str, dict[str, Any], float], ...] = (
    ("bouncing_ball", {"restitution": 0.5}, 2.0),
    ("rocking_block", {}, 8.0),
    ("painleve_rod", {"friction": 0.5}, 1.0),
    ("painleve_rod", {"friction": 0.5, "lift": 0.1}, 0.8),
    ("painleve_rod", {}, 0.2),
    ("painleve_rod", {"spin": 4.0, "tip_velocity": -3.0}, 0.2),
    (slider_crank_angles.__name__, {}, 0.04),
    ("woodpecker", {}, 0.3),
    *((f"example_{number}", {}, 1.0) for number in range(1, 8)),
)


def errors(
    names: Iterable[str] = tuple(CASES),
    counts: Iterable[int] = (50, 100, 200, 400, 800),
    accuracies: Iterable[float] = (1e-5, 1e-7, 1e-9),
) -> Iterator[Row]:
    """Compare motions by every scheme that accepts the scene at ten times with the finest event-driven one with the same law.

    setting: step, s, or for the event-driven scheme the integrator's relative accuracy; error: the largest error of a
    coordinate, m or rad, or none if the scheme has no solution; work: friction problems and evaluations of forces.
    """
    for name in names:
        place, settings, duration = CASES[name]
        whole = fb.scene(place, **settings, step=duration / SAMPLES)
        known = {law: sampled(whole, by_events(law, REFERENCE_ACCURACY))[0] for law in (impact, newton)}
        for accuracy in accuracies:
            path, work = sampled(whole, by_events(impact, accuracy))
            yield {"scene": name, "scheme": "event_driven", "setting": accuracy, **compared(path, known[impact], work)}
        for label, scheme in (SCHEMES | COMPARED).items():
            if scheme.events or scheme.refuses(whole) or (label == HIGHER and name not in ONE_CONTACT):
                continue
            for count in counts:
                path, work = sampled(replace(whole, step=duration / count), scheme, count // SAMPLES)
                law = newton if label in NEWTON else impact
                yield {"scene": name, "scheme": label, "setting": duration / count, **compared(path, known[law], work)}


def ends(cases: Iterable[tuple[str, dict[str, Any], float]] = ENDS) -> Iterator[Row]:
    """How far the event-driven scheme gets, and why it ends.

    parameters: its settings, JSON; duration: planned, s; reached: the last of ten times that was reached, s; impacts: located
    impacts; accumulations: accumulation points that the motion was continued past; events: all located events; reason: why it
    ended early, if it did.
    """
    for name, settings, duration in cases:
        made, reason = fb.scene(name, **settings, step=duration / SAMPLES), ""
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
    """Return the largest error of a coordinate; none if the motion is incomplete."""
    whole = len(path) == len(known)
    return {"error": float(np.abs(path - known).max()) if whole else None, "work": work}


def summary(tables: Tables) -> Summary:
    errors, ends = tables["errors"], tables["ends"]
    driven, stepped = errors[errors["scheme"] == EVENTS], errors[errors["scheme"] != EVENTS]
    require(driven["error"].notna().all(), "the event-driven scheme follows all scenes")
    whole, names = stepped.dropna(subset="error"), list(dict.fromkeys(errors["scene"]))
    best = [_best(name, driven, whole) for name in names]
    stopped = ends[ends["reason"] != ""]
    slopes = {key: order(group["setting"], group["error"]) for key, group in whole.groupby(["scene", "scheme"])}
    quartiles = np.quantile([slope.value for key, slope in slopes.items() if key[1] != HIGHER], [0.25, 0.5, 0.75])
    numbers = {
        "smaller": sum(row["error"] < row["stepped"] for row in best),
        "scenes": len(names),
        "followed": len(ends) - len(stopped),
        "motions": len(ends),
        "best": best,
        "quartiles": listing([f"{quartile:.1f}" for quartile in quartiles]),
        "second": listing([f"{slope} in {key[0].replace('_', ' ')}" for key, slope in slopes.items() if key[1] == HIGHER]),
        "steady": listing(sorted({key[0].replace("_", " ") for key, one in slopes.items() if max(one) - min(one) < 0.02})),
        "failed": len(stepped) - len(whole),
        "stepped": len(stepped),
        "located": ends[["impacts", "accumulations"]].sum(),
        "stopped": stopped.assign(before=stopped["reached"] + stopped["duration"] / SAMPLES).to_dict("records"),
    }
    known, schemes = errors.dropna(subset="error"), sorted(errors["scheme"].unique())
    scenes = known.groupby("scene", sort=False)
    panels = [Panel(str(name).replace("_", " "), partial(_work, errors=of, schemes=schemes)) for name, of in scenes]
    return Summary(numbers, {"work": panels})


def _best(name: str, driven: pd.DataFrame, whole: pd.DataFrame) -> dict[str, Any]:
    """Return the event-driven scheme at its middle accuracy and the most accurate time-stepping motion of a scene."""
    group = driven[driven["scene"] == name].sort_values("setting")
    chosen, best = group.iloc[len(group) // 2], whole[whole["scene"] == name].sort_values("error").iloc[0]
    facts = {"scene": name.replace("_", " "), "error": chosen["error"], "work": int(chosen["work"])}
    return facts | {"stepped": best["error"], "steps": int(best["work"]), "scheme": best["scheme"]}


def _work(ax: Axes, errors: pd.DataFrame, schemes: list[str]) -> None:
    for scheme, group in errors.groupby("scheme"):
        ordered = group.sort_values("work")
        curve(ax, schemes.index(str(scheme)), ordered["work"], ordered["error"].clip(lower=LEAST_DRAWN), str(scheme))
    finish(ax, "evaluations", "largest error, m or rad", "xy")


STUDY = Study((errors, ends), summary)
