"""The study of neighbouring starts."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import curve, finish
from frictionbench.reports.studies.numbers import listing
from frictionbench.results.studies import StudyTables

PARTED = 20.0  # times the change of the start: farther apart at the end than smooth growth in so short a motion explains
SAME = 1e-6  # m/s: answers of two solvers that differ by less
JAM, RODS, LANDING = "jam", ("rod at p > 0", "rod at p < 0"), "flat landing"
EDGE = "rod leaving at p < 0"
EVENTS = "event_driven"


def account(found: StudyTables) -> Account:
    rows, landings, lifts = found["ensembles"], found["landings"], found["lifts"]
    rows = rows.assign(parted=rows["apart"] > PARTED * rows["size"], none=rows["velocity"].isna())
    pairs = rows.groupby(["case", "scheme", "solver"])[["parted", "none"]].any().reset_index()
    inside = rows[rows["case"].isin(RODS) & ~rows["none"]]
    found.require(not inside["parted"].any(), "neighbours of the rod on the ground stay neighbours")
    parted = pairs[pairs["parted"]]
    silent = pairs[pairs["none"]]
    told = [f"{case} ({_pairs(own)})" for case, own in parted.groupby("case")]
    jam = rows[(rows["case"] == JAM) & ~rows["none"]].drop_duplicates(["scheme", "solver"])
    between = _spread(jam)
    edge = rows[(rows["case"] == EDGE) & rows["parted"]]
    events = landings[landings["scheme"] == EVENTS].sort_values("spin")
    others = landings[landings["scheme"] != EVENTS]
    small = others[others["after"] < 0.1 * others["closed"]].groupby("scheme")["delay"].max()
    error = abs(events["after"].iloc[0] / events["closed"].iloc[0] - 1)
    found.require(error < 0.01, "the event-driven spin is that of the closed form")
    steps = lifts.groupby(["step", "lift"]).agg(
        solutions=("solutions", "first"), apart=("along", lambda along: along.max() - along.min())
    )
    differ, several = steps["apart"] > SAME, steps["solutions"] > 1
    begins = steps[several].reset_index().groupby("step")["lift"].min()
    before = steps[~several].reset_index().query("lift < @begins.min()")["lift"].max()
    without = [f"{case} ({_pairs(own)})" for case, own in silent.groupby("case")]
    late = [f"{name} up to {delay:.1g} s" for name, delay in small.items()]
    return Account(
        answer=f"At edges, yes: neighbours part for good in {listing(sorted(parted['case'].unique()))}. Inside the region of "
        f"p < 0 neighbours stay neighbours; in the jam the solvers' answers {_apart(between)}.",
        result=f"On the ground the rod's neighbours end at most {_gain(inside):.2g} times as far apart as they began, on "
        f"either side of p = 0. Neighbours end more than {PARTED:g} times as far apart as they began, for some change, in "
        f"{'; '.join(told)}. As the rod's tip leaves the ground, velocities that part are up to "
        f"{edge['most_apart'].max():.2g} apart on the way and {edge['apart'].max():.1g} at the end, since the rod that opened "
        f"falls back and is caught. The census counts several solutions in {int(several.sum())} of {len(steps)} of the rod's "
        f"first steps, and the solvers' answers differ in {where_answers_differ(differ, several)}; several begin for "
        f"every step between {before:g} and {begins.max():g} g h of lift, so that the edge moves to the ground with h. A tall "
        f"block that lands flat stops; with a spin of {events['spin'].iloc[0]:.0e} rad/s, which delays the second hit by "
        f"{events['delay'].iloc[0]:.1g} s, the event-driven motion ends with {events['after'].iloc[0]:.3f} rad/s, the closed "
        f"form with {events['closed'].iloc[0]:.3f}. With a step of 2 ms less than a tenth of this is left for delays by "
        f"{listing(late)}. "
        + (f"Some step has no solution in {'; '.join(without)}. " if without else "")
        + "A simulator should report what shows this: that a step has, or may have, several solutions, and which contacts "
        "close within one step.",
        limits="Few scenes, of one body each, for 20 ms, and four neighbours for each size: there may be edges that these did "
        "not meet. That time stepping lets both corners hit at once is a choice of the model, not an error: experiments are "
        "not compared, and for bodies that deform a little the truth lies between. Chaotic growth in long motions is not "
        "measured.",
        figures=(
            Figure(
                "edges",
                "Left: the spin 15 ms after an almost flat landing, over the delay between the two hits; dotted: closed form. "
                "Right: the rod's velocity along the ground after one step of 2 ms, over the upward velocity of its tip; "
                "shaded: several solutions.",
                (
                    Panel("order of two hits", partial(_landings, landings=landings)),
                    Panel("the tip leaves", partial(_lifts, lifts=lifts[lifts["step"] == 0.002])),
                ),
            ),
        ),
    )


def _pairs(own: pd.DataFrame) -> str:
    """The schemes, each with its solvers."""
    return ", ".join(f"{scheme} with {listing(list(part['solver']))}" for scheme, part in own.groupby("scheme"))


def _gain(rows: pd.DataFrame) -> float:
    return float((rows["apart"] / rows["size"]).max())


def _spread(rows: pd.DataFrame) -> float:
    """The largest distance between velocities at the end."""
    ends = np.array(rows["velocity"].tolist(), dtype=float)
    return float(np.linalg.norm(ends[:, None] - ends[None], axis=2).max())


def _apart(distance: float) -> str:
    """How answers whose velocities are so many m/s apart differ."""
    return f"differ by up to {distance:.2g} m/s" if distance > SAME else "are the same"


def where_answers_differ(differ: pd.Series, several: pd.Series) -> str:
    """In how many steps answers differ, and whether in those with several solutions."""
    if not differ.any():
        return "none"
    where = "all of these" if differ.eq(several).all() else "these only" if several[differ].all() else "others, too"
    return f"{int(differ.sum())}, {where}"


def _landings(ax: Axes, landings: pd.DataFrame) -> None:
    for k, (scheme, own) in enumerate(landings.groupby("scheme")):
        curve(ax, k, own["delay"], own["after"], str(scheme))
    ax.axhline(landings["closed"].iloc[0], color=INK, lw=0.6, ls=":")
    finish(ax, "delay between the hits, s", "spin, rad/s", "x")


def _lifts(ax: Axes, lifts: pd.DataFrame) -> None:
    several = lifts.loc[lifts["solutions"] > 1, "lift"]
    if len(several):
        ax.axvspan(several.min(), several.max(), color=INK, alpha=0.08)
    for k, (solver, own) in enumerate(lifts.groupby("solver")):
        curve(ax, k, own["lift"], own["along"], str(solver), ms=6 - 1.5 * k)
    finish(ax, "lift over g h", "velocity along the ground, m/s")
