"""Substeps or iterations? The same number of sweeps, in one step of many or in many steps of few."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, FrictionProblem, Scene, simulation
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.solvers import solve
from studies.motions import coulomb
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, listing

STEP, DURATION = 0.01, 0.5  # s
FINER = 8  # ratio of the smallest substep to the reference's step
SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    "pushed stack": ("stack", {"blocks": 5, "push": 1.0, "friction": 0.3}),
    "heavy on light": ("stack", {"blocks": 5, "push": 1.0, "friction": 0.3, "mass_ratio": 100.0}),
    "pyramid": ("pyramid", {"rows": 4, "push": 1.0, "friction": 0.3}),
    "pile of discs": ("disc_pile", {"rows": 5, "push": 0.5, "friction": 0.3}),
    "arch": ("arch", {"stones": 7, "push": 0.5}),
}
BUDGETS = (16, 64, 256)  # sweeps in STEP
SUBSTEPS = (1, 4, 16, 64)
GAP_SCHEME = "stewart_trinkle"


def errors(
    scenes: Iterable[str] = tuple(SCENES), budgets: Iterable[int] = BUDGETS, substeps: Iterable[int] = SUBSTEPS
) -> Iterator[Row]:
    """Motions by nsgs with a number of sweeps in each substep, started from the previous substep, and by an exact solver."""
    parts = tuple(substeps)
    for name in scenes:
        known = motion(begin(name, max(parts) * FINER), coulomb)
        for part, budget in product(parts, (0, *budgets)):
            if budget and budget < part:
                continue
            stage = begin(name, part)
            path = motion(stage, Sweeps(budget // part) if budget else coulomb)
            yield {
                "scene": name,
                "substeps": part,  # in 10 ms
                "budget": budget,  # sweeps in 10 ms; 0 for the exact solver
                "error": float(np.linalg.norm(path - known, axis=1).max()),  # of a body's centre at the end, m
            }


def begin(name: str, parts: int) -> Scene:
    """Return a scene with a step of STEP / parts."""
    scene, settings = SCENES[name]
    return replace(fb.scene(scene, **settings, step=STEP / parts), duration=DURATION)


def motion(stage: Scene, answer: Any) -> Array:
    """Return the bodies' final centres, m."""
    *_, last = simulation(stage, answer, SCHEMES[GAP_SCHEME])
    return stage.geometry.centres(last.q)


class Sweeps:
    """A fixed number of sweeps of nsgs, from the previous problem's impulses if it has as many contacts."""

    def __init__(self, limit: int) -> None:
        self.limit, self.before = limit, np.zeros((0, 2))

    def __call__(self, problem: FrictionProblem) -> Array:
        start = self.before if len(self.before) == problem.contacts else None
        self.before = solve(problem, "nsgs", tol=1e-12, limit=self.limit, start=start).impulse
        return self.before


def summary(tables: Tables) -> Summary:
    rows = tables["errors"]
    exact, swept = rows[rows["budget"] == 0], rows[rows["budget"] > 0]
    one = swept[swept["substeps"] == 1].set_index(["scene", "budget"])["error"]
    best = swept.loc[swept.groupby(["scene", "budget"])["error"].idxmin()].set_index(["scene", "budget"])
    gain = one / best["error"]
    second = swept.groupby(["scene", "budget"])["error"].apply(lambda errors: errors.nsmallest(2).iloc[-1])
    pairs = swept.merge(exact, on=["scene", "substeps"], suffixes=("", "_exact"))
    split = best["substeps"] > 1
    coarse = exact[exact["substeps"] == 1].set_index("scene")["error"]
    numbers = {
        "split": f"{split.sum()} of {len(split)}",
        "gain": f"{gain[split].median():.2g}",
        "gains": f"{gain[split].min():.2g} to {gain[split].max():.3g}",
        "gain_all": f"{gain.median():.2g}",
        "close": (second < 1.1 * best["error"]).sum(),
        "cancel": f"{(pairs['error'] < 0.9 * pairs['error_exact']).sum()} of {len(pairs)}",
        "whole": listing([f"{scene} with {budget}" for scene, budget in best.index[~split]]),
        "each": "; ".join(f"{scene}: {_said(part)}" for scene, part in best.reset_index().groupby("scene", sort=False)),
        "exact": ", ".join(f"{scene} {1000 * error:.2g}" for scene, error in coarse.items()),
    }
    panels = (Panel(str(scene), partial(_draw, part=part)) for scene, part in rows.groupby("scene", sort=False))
    return Summary(numbers, {"errors": tuple(panels)})


def _said(part: pd.DataFrame) -> str:
    return ", ".join(f"{row.substeps} of {row.budget // row.substeps} ({1000 * row.error:.2g} mm)" for row in part.itertuples())


def _draw(ax: Axes, part: pd.DataFrame) -> None:
    for k, (budget, rows) in enumerate(part.groupby("budget")):
        label = f"{budget} sweeps in 10 ms" if budget else "exact"
        curve(ax, k, rows["substeps"], rows["error"], label, **({} if budget else {"color": INK, "ls": ":", "marker": ""}))
    finish(ax, "substeps in 10 ms", "error at the end, m", "xy")


STUDY = Study((errors,), summary)
