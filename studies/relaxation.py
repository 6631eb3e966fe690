"""Can a step with friction be recast as a convex problem? The relaxation's error, and Anitescu and Hart's fixed point."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import GRAVITY, velocity_distance
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.solvers import solve
from studies.motions import apart, coulomb, path, relaxed
from studies.outcomes import SAME, STARTS, found
from studies.study import Row, Study, Summary, Tables, curve, finish, listing, order, require

PILES: dict[str, dict[str, Any]] = {
    "stack": {"blocks": 5},
    "pyramid": {"rows": 4},
    "wall": {"rows": 3, "columns": 3},
    "arch": {"stones": 9},
}
FRICTIONS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6)
STEPS = (1e-4, 1e-3, 1e-2)
GAP_SCHEME = "stewart_trinkle"
SUDDEN, SMOOTH = "sudden", "smooth"
ANY = 1e-3  # s, an arbitrary step: with a push of 10 m/s^2 the first problem and its answer are proportional to it
ANSWER_ERROR = 1e-10  # smaller errors may be due to the answers' own


def errors(frictions: Iterable[float] = FRICTIONS, steps: Iterable[float] = STEPS) -> Iterator[Row]:
    """First problems of pushed piles: the relaxation compared with Coulomb's law, and two iterations that converge to the law.

    anitescu_hart: relaxations until 1e-8; null if not reached; staggered: rounds of staggered projections until 1e-8; null
    if not reached.
    """
    pushes = (*((SUDDEN, 1.0, step) for step in steps), (SMOOTH, 10.0 * ANY, ANY))  # m/s in a step
    for (name, size), (kind, push, step), friction in product(PILES.items(), pushes, frictions):
        problem = fb.scene(name, **size, push=push, friction=friction, step=step).problem()
        w, finest = problem.velocity(relaxed(problem)), [r for *_, r in found(problem, STARTS) if r is not None]
        distances = [apart(problem, w, problem.velocity(r)) for r in finest]
        counts = {
            spec: answer.work[unit] if fb.residual(problem, answer.impulse) <= 1e-8 else None
            for spec, unit in (("anitescu_hart", "relaxations"), ("staggered", "rounds"))
            for answer in (solve(problem, spec, tol=1e-8),)
        }
        yield {
            "scene": name,  # pile, its lowest or topmost body pushed
            "push": kind,  # by 1 m/s at once, or by 10 m/s^2
            "friction": friction,  # mu
            "step": step,  # s
            # |v_relaxed - v_Coulomb|_M / |v*|_M for the nearest and the farthest motion that was found by Coulomb's law
            "error": min(distances),
            "farthest": max(distances),
            "several": any((velocity_distance(problem, r, finest[0]) or 0.0) > SAME for r in finest),  # motions
            **counts,
        }


def gaps(friction: float = 0.6, speed: float = 1.0, steps: Iterable[float] = (0.016, 0.008, 0.004, 0.002)) -> Iterator[Row]:
    """How high the relaxation lifts a sliding block: after a sudden start, and after a smooth one down a slope."""
    for step in steps:
        thrown = fb.scene("stopping_block", friction=friction, speed=speed, step=step, duration=0.4)
        down = fb.scene("incline", friction=0.3, angle=0.5, step=step, duration=0.4)
        normal = np.array([-np.sin(0.5), np.cos(0.5)])
        q = path(down, relaxed, GAP_SCHEME)
        sliding = np.abs(np.diff(q[:, :2] @ np.array([np.cos(0.5), np.sin(0.5)])) / step).max()
        yield {
            "step": step,  # s
            "hop": np.ptp(path(thrown, relaxed, GAP_SCHEME)[:, 1]),  # height of the relaxed block after a sudden start, m
            # (mu v/(1 + mu^2))^2/(2 g), its limit for small steps, m
            "hop_predicted": (friction * speed / (1 + friction**2)) ** 2 / (2 * GRAVITY),
            # greatest gap of the relaxed block that begins to slide smoothly, m
            "smooth": ((q[:, :2] - q[0, :2]) @ normal).max(),
            "smooth_predicted": step * 0.3 * sliding,  # h mu |v_t| at its greatest speed, m
            "coulomb": np.ptp(path(thrown, coulomb, GAP_SCHEME)[:, 1]),  # the same by Coulomb's law, m
        }


def summary(tables: Tables) -> Summary:
    errors, gaps = tables["errors"], tables["gaps"]
    hop, gap = gaps.iloc[-1], order(gaps["step"], gaps["smooth"])
    require(np.allclose(gaps["smooth"], gaps["smooth_predicted"], rtol=0.02), "the smooth gap is h mu |v_t|")
    require(abs(hop["hop"] / hop["hop_predicted"] - 1) < 0.05, "the hop is that of the closed form")
    usual = errors[errors["friction"].between(0.1, 0.8)]
    sudden = usual[usual["push"] == SUDDEN]
    by_step = sudden.groupby("step")["error"].median()
    require(by_step.iloc[0] >= by_step.iloc[-1], "smaller steps do not lessen the error of sudden pushes")
    smooth = usual[usual["push"] == SMOOTH].set_index(["scene", "friction"]).sort_index()
    nearest = smooth["error"]
    by_pile = usual.groupby(["push", "scene"]).agg(median=("error", "median"), most=("farthest", "max"))
    counts = errors.groupby("friction")[["anitescu_hart", "staggered"]].agg(["count", "median"])
    low, high = counts.index.min(), counts.index[counts["anitescu_hart"]["count"] > 0].max()
    arrived, cases = errors[["anitescu_hart", "staggered"]].notna(), errors[["scene", "friction"]]
    numbers = {
        **{f"most_{push}": _percent(error) for push, error in by_pile["most"].groupby("push").max().items()},
        "rows": [
            (name, *map(_percent, by_pile.loc[(SUDDEN, name)]), *map(_percent, smooth["error"][name], smooth["farthest"][name]))
            for name in PILES
        ],
        "frictions": [f"{mu:g}" for mu in smooth.index.unique("friction")],
        "same": int((nearest < ANSWER_ERROR).sum()),
        "pairs": len(smooth),
        "least": _percent(nearest[nearest >= ANSWER_ERROR].min()),
        "several": int(errors["several"].sum()),
        "where": listing(sorted(errors[errors["several"]]["scene"].unique())),
        "between": _percent((sudden["farthest"] - sudden["error"]).max()),
        "arrived": arrived.sum(),
        "lost": {
            name: listing([f"{pile} at mu = {mu:g} ({n})" for (pile, mu), n in cases[~same].value_counts(sort=False).items()])
            for name, same in arrived.items()
        },
        "cases": len(errors),
        "steps": [f"{step:g}" for step in by_step.index],
        "by_step": [_percent(error) for error in by_step],
        "hops": [f"{1000.0 * hop[name]:.1f}" for name in ("hop", "hop_predicted")],
        "smooth": f"{gap.value:.2f}",
        "taken": [(f"{counts['anitescu_hart']['median'][mu]:.0f}", f"{mu:g}") for mu in (low, high)],
    }
    figures = {
        "errors": (
            Panel("error of one relaxation", partial(_errors, errors=errors)),
            Panel("relaxations in turn", partial(_counts, errors=errors)),
        ),
        "artefacts": (Panel("two artefacts", partial(_gaps, gaps=gaps)),),
    }
    return Summary(numbers, figures)


def _percent(error: float, farthest: float = 0.0) -> str:
    """Format an error, and the range up to that from the farthest motion if it is another one as shown."""
    low, high = ("0" if one < ANSWER_ERROR else f"{100 * one:.2g} %" for one in (error, farthest))
    return low if high in (low, "0") else f"{low.removesuffix(' %')} to {high}"


def _errors(ax: Axes, errors: pd.DataFrame) -> None:
    for k, (name, group) in enumerate(errors[errors["step"] == 0.001].groupby("scene")):
        for push, line in ((SUDDEN, "-"), (SMOOTH, ":")):
            rows = group[group["push"] == push]
            curve(ax, k, rows["friction"], rows["error"].clip(lower=1e-6), f"{name}, {push}", ls=line)
    finish(ax, "mu", "error of the velocity", "xy")


def _counts(ax: Axes, errors: pd.DataFrame) -> None:
    median = errors.groupby("friction")[["anitescu_hart", "staggered"]].median()
    for k, name in enumerate(median):
        curve(ax, k, median.index, median[name], f"{name}, median")
        reached = errors.groupby("friction")[name].max()
        curve(ax, k, median.index, reached, lw=0.5, marker="")
    finish(ax, "mu", "iterations", "xy")


def _gaps(ax: Axes, gaps: pd.DataFrame) -> None:
    for k, (column, start) in enumerate({"hop": "sudden start", "smooth": "smooth start"}.items()):
        curve(ax, k, gaps["step"], gaps[column], start)
        ax.plot(gaps["step"], gaps[f"{column}_predicted"], color=INK, lw=0.7, ls=":", label="" if k else "closed forms")
    finish(ax, "step, s", "height, m", "xy")


STUDY = Study((errors, gaps), summary)
