"""Substeps or iterations? The same number of sweeps, in one step of many or in many steps of few."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, FrictionProblem, simulation
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.solvers import solve
from studies.motions import coulomb
from studies.study import Array, Row, Study, Summary, Tables, curve, finish

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
NEGLIGIBLE = 0.1  # share of the step's error below which the solver's own does not matter
SPREAD = [0.5, 0.0, 1.0]  # the median, the least and the largest, as quantiles
TIE = 1.25  # ratio of errors that counts as none: the reference makes the finest an eighth too small


def errors(
    scenes: Iterable[str] = tuple(SCENES), budgets: Iterable[int] = BUDGETS, substeps: Iterable[int] = SUBSTEPS
) -> Iterator[Row]:
    """Motions by nsgs with a number of sweeps in each substep, started from the previous substep, and by an exact solver.

    Distances are the largest of a body's centre after any 10 ms, m.
    """
    parts = tuple(substeps)
    for name in scenes:
        known = motion(name, max(parts) * FINER, coulomb)
        for part in parts:
            exact = motion(name, part, coulomb)
            for budget in (0, *(budget for budget in budgets if budget >= part)):
                sweeps = Sweeps(budget // part)
                path = motion(name, part, sweeps) if budget else exact
                yield {
                    "scene": name,
                    "substeps": part,  # in 10 ms
                    "budget": budget,  # the most sweeps in 10 ms; 0 for the exact solver
                    "used": sweeps.used * STEP / DURATION,  # sweeps in 10 ms, in the mean
                    "error": farthest(path, known),  # from the reference
                    "own": farthest(path, exact),  # the error of the solver alone: from exact steps of the same length
                }


def motion(name: str, parts: int, answer: Any) -> Array:
    """Return the bodies' centres (samples, bodies, 2) of a scene after every STEP, by steps of STEP / parts, m."""
    scene, settings = SCENES[name]
    stage = replace(fb.scene(scene, **settings, step=STEP / parts), duration=DURATION)
    steps = simulation(stage, answer, SCHEMES["stewart_trinkle"])
    return np.array([stage.geometry.centres(now.q) for now in islice(steps, parts, None, parts)])


def farthest(path: Array, other: Array) -> float:
    return float(np.linalg.norm(path - other, axis=-1).max())


class Sweeps:
    """At most a number of sweeps of nsgs, from the problem before if it has as many contacts. used: sweeps of all steps."""

    def __init__(self, limit: int) -> None:
        self.limit, self.before, self.used = limit, np.zeros((0, 2)), 0

    def __call__(self, problem: FrictionProblem) -> Array:
        start = self.before if len(self.before) == problem.contacts else None
        answer = solve(problem, "nsgs", tol=1e-12, limit=self.limit, start=start)
        self.before, self.used = answer.impulse, self.used + answer.work["sweeps"]
        return self.before


def summary(tables: Tables) -> Summary:
    rows, case = tables["errors"], ["scene", "budget"]
    exact, swept = rows[rows["budget"] == 0].set_index("scene"), rows[rows["budget"] > 0]
    several = swept[swept["substeps"] > 1]
    best = several.loc[several.groupby(case)["error"].idxmin()][[*case, "substeps", "error"]]
    cases = swept[swept["substeps"] == 1].merge(best, on=case, suffixes=("", "_best"))
    step, doubt = (cases["scene"].map(exact.loc[exact["substeps"] == n, "error"]) for n in (1, exact["substeps"].max()))
    gain, apart = cases["error"] / cases["error_best"], (cases["error"] - cases["error_best"]).abs()
    better = np.select([gain.between(1 / TIE, TIE) | (apart < 2 * doubt), gain > 1], ["tie", "substeps"], "one step")
    alone = cases["own"] < NEGLIGIBLE * step
    cases = cases.assign(step=step, doubt=doubt, gain=gain, better=better)
    pairs = several.merge(cases[[*case, "error"]], on=case, suffixes=("", "_one"))
    pairs["factor"] = pairs["error_one"] / pairs["error"]
    exactly = swept.merge(exact, on=["scene", "substeps"], suffixes=("", "_exact"))
    numbers = {
        "cases": len(cases),
        "cancel": f"{(exactly['error'] < exactly['error_exact'] / TIE).sum()} of {len(exactly)}",
        "parts": [(part["better"].value_counts(), part["gain"].quantile(SPREAD)) for part in (cases[alone], cases[~alone])],
        "gain": gain.quantile(SPREAD),
        "fixed": [(n, len(part), part["factor"].quantile(SPREAD)) for n, part in pairs.groupby("substeps")],
        "single": pairs.loc[pairs["budget"] == pairs["substeps"], "factor"].quantile(SPREAD),
        "tie": TIE,
        "rows": cases.to_dict("records"),
    }
    panels = (Panel(str(scene), partial(_draw, part=part)) for scene, part in rows.groupby("scene", sort=False))
    return Summary(numbers, {"errors": tuple(panels)})


def _draw(ax: Axes, part: pd.DataFrame) -> None:
    for k, (budget, rows) in enumerate(part.groupby("budget")):
        label = f"{budget} sweeps in 10 ms" if budget else "exact"
        curve(ax, k, rows["substeps"], rows["error"], label, **({} if budget else {"color": INK, "ls": ":", "marker": ""}))
    finish(ax, "substeps in 10 ms", "largest error, m", "xy")


STUDY = Study((errors,), summary)
