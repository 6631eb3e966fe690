"""The study of the convex relaxation: where it errs, what that costs, and whether relaxations in turn arrive at the law."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import curve, finish
from frictionbench.reports.studies.numbers import order, share
from frictionbench.results.studies import StudyTables


def account(found: StudyTables) -> Account:
    errors, cycle, gaps, stopping, falls = (found[name] for name in ("errors", "cycle", "gaps", "stopping", "falls"))
    found.require(cycle["solutions"].eq(1).all(), "the single contact has one solution")
    found.require(np.allclose(cycle["predicted"], cycle["measured"], rtol=1e-3), "the fixed point has the predicted rate")
    cycling = cycle[cycle["cycles"]]
    found.require((cycling["predicted"] > 1).all() and len(cycling), "the fixed point cycles where its rate exceeds 1")
    hop, smooth = gaps.iloc[-1], order(gaps["step"], gaps["smooth"])
    found.require(np.allclose(gaps["smooth"], gaps["smooth_predicted"], rtol=0.02), "the smooth gap is h mu |v_t|")
    found.require(abs(hop["hop"] / hop["hop_predicted"] - 1) < 0.05, "the hop is that of the closed form")
    usual = errors[errors["friction"].between(0.1, 0.8)]
    by_step = usual.groupby("step")["error"].median()
    found.require(by_step.iloc[0] >= by_step.iloc[-1], "smaller steps do not lessen the error")
    counts = errors.groupby("friction")[["anitescu_hart", "staggered"]].agg(["count", "median"])
    arrived = {name: int(errors[name].notna().sum()) for name in ("anitescu_hart", "staggered")}
    apart = (stopping["coulomb"] - stopping["relaxed"]).abs() / stopping["exact"]
    finest = stopping["step"] == stopping["step"].min()
    agree, many = int((falls["coulomb"] == falls["relaxed"]).sum()), len(falls)
    low, high = counts.index.min(), counts.index[counts["anitescu_hart"]["count"] > 0].max()
    return Account(
        answer=f"Not in one: the relaxation's velocities are off by a median of {100 * usual['error'].median():.0f} % for mu "
        f"of 0.1 to 0.8 where bodies are pushed suddenly, and small steps do not help; a sequence of "
        f"relaxations arrives at Coulomb's law in {arrived['anitescu_hart']} of {len(errors)} cases.",
        result=f"Over steps from {errors['step'].min():g} to {errors['step'].max():g} s the median error of pushed piles goes "
        f"from {by_step.iloc[0]:.2f} to {by_step.iloc[-1]:.2f}. There are two errors. Started suddenly at 1 m/s, a block hops "
        f"by {1e3 * hop['hop']:.1f} mm at the smallest step; the closed form has {1e3 * hop['hop_predicted']:.1f} mm in the "
        f"limit. Where sliding begins smoothly the block rides on a gap of h mu |v_t|, which vanishes with the order "
        f"{smooth} of the step. A motion forgives much of it, because friction times the total normal impulse is the same: "
        f"stopping distances by the two models differ by at most {100 * apart.max():.1f} % and, at the smallest step, by "
        f"{100 * apart[finest].max():.1f} %; whether a thrown block tips over is the same in {agree} of {many} throws"
        + (", all of them" if agree == many else "")
        + f". Anitescu and Hart's fixed point takes a median of {counts['anitescu_hart']['median'][low]:.0f} relaxations at mu "
        f"= {low:g} and of {counts['anitescu_hart']['median'][high]:.0f} at mu = {high:g}, and staggered projections arrive in "
        f"{arrived['staggered']} cases. One contact shows why it may fail: its rate, by the closed form and measured alike, "
        f"exceeds 1 between mu = {cycling['friction'].min():.2f} and {cycling['friction'].max():.2f}, where it ends in a cycle "
        f"of two although there is one solution; staggered projections solve "
        f"{share(int(cycling['staggered'].eq('solved').sum()), len(cycling))} of these.",
        limits="The piles are small, planar and pushed suddenly, which is the relaxation's worst case; a simulation in which "
        "bodies slide smoothly errs less. Its uniqueness and speed, for which it is used, are not weighed here. That a block "
        "tips over or not was compared for one shape.",
        figures=(
            Figure(
                "errors",
                "Left: the relaxation's error in the velocities of pushed piles, each line a pile, for the step of 0.001 s. "
                "Right: iterations until Coulomb's law holds to 1e-8; lines end where it does not.",
                (
                    Panel("error of one relaxation", partial(_errors, errors=errors)),
                    Panel("relaxations in turn", partial(_counts, errors=errors)),
                ),
            ),
            Figure(
                "artefacts",
                "Left: the rate of the fixed point at one contact, closed form and measured; crosses: it ends in a cycle. "
                "Right: how high the relaxation lifts a block, after a sudden and after a smooth start.",
                (
                    Panel("one contact with b = 0.97", partial(_rates, cycle=cycle)),
                    Panel("two artefacts", partial(_gaps, gaps=gaps)),
                ),
            ),
        ),
    )


def _errors(ax: Axes, errors: pd.DataFrame) -> None:
    for k, (name, own) in enumerate(errors[errors["step"] == 0.001].groupby("scene")):
        curve(ax, k, own["friction"], own["error"], str(name))
    finish(ax, "mu", "error of the velocity", "x")


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
