"""Can a step with friction be recast as a convex problem? The relaxation's error, and Anitescu and Hart's fixed point."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import GRAVITY, FrictionProblem, census
from frictionbench.reports import INK, Panel
from frictionbench.solvers import solve
from studies.motions import apart, coulomb, path, relaxed
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, order, require

PILES: dict[str, dict[str, Any]] = {
    "stack": {"blocks": 5},
    "pyramid": {"rows": 4},
    "wall": {"rows": 3, "columns": 3},
    "arch": {"stones": 9},
}
FRICTIONS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6)
STEPS = (1e-4, 1e-3, 1e-2)
GAPS = "stewart_trinkle"
SUDDEN, SMOOTH = "sudden", "smooth"
PUSHES: dict[str, Callable[[float], float]] = {SUDDEN: lambda step: 1.0, SMOOTH: lambda step: 10.0 * step}  # m/s in a step


def errors(frictions: Iterable[float] = FRICTIONS, steps: Iterable[float] = STEPS) -> Iterator[Row]:
    """First problems of pushed piles: the relaxation beside Coulomb's law, and two iterations towards the law.

    anitescu_hart: relaxations until 1e-8; null if not reached; staggered: rounds of staggered projections until 1e-8; null
    if not reached.
    """
    for (name, size), (kind, push) in product(PILES.items(), PUSHES.items()):
        for friction in frictions:
            for step in steps:
                problem = fb.scene(name, **size, push=push(step), friction=friction, step=step).problem()
                v, w = problem.velocity(coulomb(problem)), problem.velocity(relaxed(problem))
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
                    "residual": fb.residual(problem, relaxed(problem)),  # of the relaxation's answer by Coulomb's law
                    # |v_relaxed - v_Coulomb|_M / |v*|_M
                    "error": apart(problem, w, v),
                    **counts,
                }


def cycle(frictions: Iterable[float] = np.linspace(0.45, 1, 12), b: float = 0.97, rounds: int = 300) -> Iterator[Row]:
    """One contact W = [[1, b], [b, 1]] that slides along +t: the fixed point written out, the solver, and staggering."""
    for mu in frictions:
        one = FrictionProblem(
            mass=np.linalg.inv([[1, b], [b, 1]]),
            normal=[[1, 0]],
            tangent=[[0, 1]],
            friction=[mu],
            free_velocity=[-1, 10],
            bias=[0],
        )
        exact = abs(one.contact_velocity(coulomb(one))[0, 1])
        near, far = (fixed_point(one, start, count) for start, count in ((exact * (1 + 1e-3), 3), (0.0, rounds)))
        away = np.abs(near - exact)
        yield {
            "friction": mu,  # mu
            "solutions": census(one).count,  # number of solutions
            "predicted": abs(mu * (mu - b)) / (1 - 2 * mu * b + mu**2),  # rate of the fixed point by its closed form
            # rate of the fixed point written out, from 1e-3 beside the solution
            "measured": float((away[3] / away[0]) ** (1 / 3)),
            "converges": bool(abs(far[-1] - exact) <= 1e-6 * exact),  # whether from 0 it arrives within 1e-6 of the solution
            # whether from 0 it ends in a cycle of two
            "cycles": bool(abs(far[-1] - far[-3]) <= 1e-6 * exact and abs(far[-1] - far[-2]) > 1e-3 * exact),
            "solver": solve(one, "anitescu_hart", tol=1e-8).status.name.lower(),  # status of anitescu_hart
            "staggered": solve(one, "staggered", tol=1e-8).status.name.lower(),  # status of staggered projections
        }


def fixed_point(one: FrictionProblem, start: float, count: int) -> Array:
    """lam^0 ... lam^count; each relaxation is solved by another method than that of the solver anitescu_hart."""
    lams = [start]
    for _ in range(count):
        shifted = one.replace(bias=one.friction * lams[-1])
        lams.append(abs(one.contact_velocity(relaxed(shifted))[0, 1]))
    return np.array(lams)


def gaps(friction: float = 0.6, speed: float = 1.0, steps: Iterable[float] = (0.016, 0.008, 0.004, 0.002)) -> Iterator[Row]:
    """How high the relaxation lifts a sliding block: after a sudden start, and after a smooth one down a slope."""
    for step in steps:
        thrown = fb.scene("stopping_block", friction=friction, speed=speed, step=step, duration=0.4)
        down = fb.scene("incline", friction=0.3, angle=0.5, step=step, duration=0.4)
        normal = np.array([-np.sin(0.5), np.cos(0.5)])
        q = path(down, relaxed, GAPS)
        sliding = np.abs(np.diff(q[:, :2] @ np.array([np.cos(0.5), np.sin(0.5)])) / step).max()
        yield {
            "step": step,  # s
            "hop": np.ptp(path(thrown, relaxed, GAPS)[:, 1]),  # greatest height of the relaxed block after a sudden start, m
            # (mu v/(1 + mu^2))^2/(2 g), its limit for small steps, m
            "hop_predicted": (friction * speed / (1 + friction**2)) ** 2 / (2 * GRAVITY),
            # greatest gap of the relaxed block that begins to slide smoothly, m
            "smooth": ((q[:, :2] - q[0, :2]) @ normal).max(),
            "smooth_predicted": step * 0.3 * sliding,  # h mu |v_t| at its greatest speed, m
            "coulomb": np.ptp(path(thrown, coulomb, GAPS)[:, 1]),  # greatest height by Coulomb's law after the sudden start, m
        }


def stopping(frictions: Iterable[float] = (0.2, 0.6, 1.0), steps: Iterable[float] = (0.016, 0.008, 0.004)) -> Iterator[Row]:
    """How far a block slides until it stops, by both models."""
    for friction in frictions:
        for step in steps:
            stage = fb.scene("stopping_block", friction=friction, step=step, duration=1.1 / (friction * GRAVITY))
            yield {
                "friction": friction,  # mu
                "step": step,  # s
                "exact": 1 / (2 * friction * GRAVITY),  # v^2/(2 mu g), m
                "coulomb": path(stage, coulomb, GAPS)[-1, 0],  # distance by Coulomb's law, m
                "relaxed": path(stage, relaxed, GAPS)[-1, 0],  # distance by the relaxation, m
            }


def falls(
    frictions: Iterable[float] = (0.5, 0.6, 0.7, 0.8), speeds: Iterable[float] = np.linspace(1, 4, 13), steps: int = 150
) -> Iterator[Row]:
    """A block twice as high as wide is thrown along the ground: whether it tips over, by both models.

    coulomb: whether it tips over by Coulomb's law; relaxed: whether it tips over by the relaxation.
    """
    for friction in frictions:
        for speed in speeds:
            stage = fb.scene("two_corner_block", aspect=2.0, friction=friction, velocity=speed)
            ends = {
                model: path(stage, answer, GAPS, steps)[-1] for model, answer in (("coulomb", coulomb), ("relaxed", relaxed))
            }
            yield {
                "friction": friction,  # mu
                "speed": speed,  # at which the block is thrown, m/s
                **{model: bool(abs(q[2]) > 1.0) for model, q in ends.items()},
                "apart": float(np.hypot(*(ends["coulomb"] - ends["relaxed"])[:2])),  # distance of the two blocks at the end, m
            }


def summary(found: Tables) -> Summary:
    errors, cycle, gaps, stopping, falls = (found[name] for name in ("errors", "cycle", "gaps", "stopping", "falls"))
    require(cycle["solutions"].eq(1).all(), "the single contact has one solution")
    require(np.allclose(cycle["predicted"], cycle["measured"], rtol=1e-3), "the fixed point has the predicted rate")
    cycling = cycle[cycle["cycles"]]
    require((cycling["predicted"] > 1).all() and len(cycling), "the fixed point cycles where its rate exceeds 1")
    hop, smooth = gaps.iloc[-1], order(gaps["step"], gaps["smooth"])
    require(np.allclose(gaps["smooth"], gaps["smooth_predicted"], rtol=0.02), "the smooth gap is h mu |v_t|")
    require(abs(hop["hop"] / hop["hop_predicted"] - 1) < 0.05, "the hop is that of the closed form")
    usual = errors[errors["friction"].between(0.1, 0.8)]
    by_step = usual.groupby(["push", "step"])["error"].median()
    require(by_step[SUDDEN].iloc[0] >= by_step[SUDDEN].iloc[-1], "smaller steps do not lessen the error of sudden pushes")
    by_push = usual.groupby("push")["error"].median()
    by_pile = usual.groupby(["push", "scene"])["error"].median()
    counts = errors.groupby("friction")[["anitescu_hart", "staggered"]].agg(["count", "median"])
    arrived = {name: int(errors[name].notna().sum()) for name in ("anitescu_hart", "staggered")}
    apart = (stopping["coulomb"] - stopping["relaxed"]).abs() / stopping["exact"]
    finest = stopping["step"] == stopping["step"].min()
    agree, many = int((falls["coulomb"] == falls["relaxed"]).sum()), len(falls)
    low, high = counts.index.min(), counts.index[counts["anitescu_hart"]["count"] > 0].max()
    numbers = {
        "sudden": f"{100 * by_push[SUDDEN]:.0f}",
        "smooth_error": f"{100 * by_push[SMOOTH]:.2g}",
        **{f"piles_{push}": _by_pile(by_pile[push]) for push in PUSHES},
        "smooth_finest": f"{by_step[SMOOTH].iloc[0]:.1g}",
        "smooth_coarsest": f"{by_step[SMOOTH].iloc[-1]:.1g}",
        "arrived": arrived["anitescu_hart"],
        "cases": len(errors),
        "first_step": f"{errors['step'].min():g}",
        "last_step": f"{errors['step'].max():g}",
        "finest_error": f"{by_step[SUDDEN].iloc[0]:.2f}",
        "coarsest_error": f"{by_step[SUDDEN].iloc[-1]:.2f}",
        "hop": f"{1000.0 * hop['hop']:.1f}",
        "hop_predicted": f"{1000.0 * hop['hop_predicted']:.1f}",
        "smooth": smooth,
        "apart": f"{100 * apart.max():.1f}",
        "apart_finest": f"{100 * apart[finest].max():.1f}",
        "agree": agree,
        "throws": many,
        "all_agree": agree == many,
        "at_low": f"{counts['anitescu_hart']['median'][low]:.0f}",
        "low": f"{low:g}",
        "at_high": f"{counts['anitescu_hart']['median'][high]:.0f}",
        "high": f"{high:g}",
        "staggered": arrived["staggered"],
        "cycle_from": f"{cycling['friction'].min():.2f}",
        "cycle_to": f"{cycling['friction'].max():.2f}",
        "cycle_staggered": f"{cycling['staggered'].eq('solved').sum()} of {len(cycling)}",
    }
    figures = {
        "errors": (
            Panel("error of one relaxation", partial(_errors, errors=errors)),
            Panel("relaxations in turn", partial(_counts, errors=errors)),
        ),
        "artefacts": (
            Panel("one contact with b = 0.97", partial(_rates, cycle=cycle)),
            Panel("two artefacts", partial(_gaps, gaps=gaps)),
        ),
    }
    return Summary(numbers, figures)


def _by_pile(errors: pd.Series) -> str:
    return ", ".join(f"{name} {error:.2g}" for name, error in errors.items())


def _errors(ax: Axes, errors: pd.DataFrame) -> None:
    for k, (name, own) in enumerate(errors[errors["step"] == 0.001].groupby("scene")):
        for push, line in ((SUDDEN, "-"), (SMOOTH, ":")):
            rows = own[own["push"] == push]
            curve(ax, k, rows["friction"], rows["error"].clip(lower=1e-6), f"{name}, {push}", ls=line)
    finish(ax, "mu", "error of the velocity", "xy")


def _counts(ax: Axes, errors: pd.DataFrame) -> None:
    median = errors.groupby("friction")[["anitescu_hart", "staggered"]].median()
    for k, name in enumerate(median):
        curve(ax, k, median.index, median[name], f"{name}, median")
        reached = errors.groupby("friction")[name].max()
        curve(ax, k, median.index, reached, lw=0.5, marker="")
    finish(ax, "mu", "iterations", "xy")


def _rates(ax: Axes, cycle: pd.DataFrame) -> None:
    curve(ax, 0, cycle["friction"], cycle["predicted"], "closed form", marker="")
    curve(ax, 0, cycle["friction"], cycle["measured"], "measured", ls="")
    cycling = cycle[cycle["cycles"]]
    ax.plot(cycling["friction"], cycling["measured"], "x", color=INK, ms=8, label="cycle of two")
    ax.axhline(1, color=INK, lw=0.6, ls=":")
    finish(ax, "mu", "rate")


def _gaps(ax: Axes, gaps: pd.DataFrame) -> None:
    curve(ax, 0, gaps["step"], gaps["hop"], "sudden start")
    ax.plot(gaps["step"], gaps["hop_predicted"], color=INK, lw=0.7, ls=":", label="closed forms")
    curve(ax, 1, gaps["step"], gaps["smooth"], "smooth start")
    ax.plot(gaps["step"], gaps["smooth_predicted"], color=INK, lw=0.7, ls=":")
    finish(ax, "step, s", "height, m", "xy")


STUDY = Study((errors, cycle, gaps, stopping, falls), summary)
