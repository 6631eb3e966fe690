"""The study of the circular cone and its polygons."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.problems.verdicts import ACCEPTED, Verdict
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.drawing.text import seconds
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import COLOURS, curve, finish
from frictionbench.reports.studies.numbers import order
from frictionbench.results.studies import StudyTables

CONE = "interior_point"
KINK = 1e-9  # errors below it are rounding
DISTINCT = 1e-4  # solutions further apart are two, and not one to a few digits


def account(found: StudyTables) -> Account:
    ball, problems, solves = found["ball"], found["problems"], found["solves"]
    cone, polygons = ball[ball["facets"] == 0].iloc[0], ball[ball["facets"] > 0]
    slope = order(polygons["facets"], polygons["from_cone"])
    erring = problems[problems["error"] > KINK].groupby("facets")["error"].median()
    of_problems = order(erring.index, erring)
    two = problems[problems["solutions_apart"] > DISTINCT].groupby("number").first()
    times = _times(solves)
    ratio = times.div(times["cone"], axis=0).median()
    done = solves[solves["verdict"].isin([*ACCEPTED, Verdict.RELAXED])].groupby("variant").size()
    coarse, fine = polygons["facets"].min(), polygons["facets"].max()
    enough = polygons.loc[polygons["from_cone"] < cone["from_parabola"], "facets"]
    found.require(slope.value < -0.5, "more facets approach the cone")
    shown = [name for name in ratio.index if name != "cone"]
    return Account(
        answer=f"The cone: a polygon of {coarse} facets bends the ball's path by "
        f"{100 * polygons['from_cone'].iloc[0]:.1f} cm in {np.hypot(cone['x'][-1], cone['y'][-1]):.2f} m, {fine} facets by "
        f"{1000 * polygons['from_cone'].iloc[-1]:.1f} mm, and from {_dearer(ratio)} facets on Lemke's method takes longer than "
        f"{CONE} on the cone in the median.",
        result=f"The error of the ball's path falls with the order {slope} in the number of facets, not evenly, since it "
        f"depends on where the corners lie; the deficit of a polygon's friction, 1 - cos(pi/K), falls with order -2. The step "
        f"of {1000 * cone['step']:g} ms alone leaves {1000 * cone['from_parabola']:.1f} mm with the cone"
        + (f", below which the polygon's error is from {enough.min()} facets on. " if len(enough) else ". ")
        + f"Over {problems['number'].nunique()} spatial problems the velocity's median error falls from "
        f"{erring.iloc[0]:.2g} with {erring.index[0]} facets to {erring.iloc[-1]:.2g} with {erring.index[-1]}, with the order "
        f"{of_problems}. Time over that of {CONE} on the cone, problem by problem within this run, in the median: "
        + ", ".join(f"{ratio[name]:.2g} with {name} facets" for name in shown)
        + f"; the cone takes {seconds(times['cone'].median())}. "
        + (
            f"In {len(two)} of the problems ({', '.join(sorted({*two['scene']}))}) the finest polygon leads to another "
            "solution of Coulomb's law than the cone's method finds, confirmed by refining its answer on the cone to 1e-10; "
            "errors are to the nearer one. "
            if len(two)
            else ""
        )
        + f"All {done.get(CONE, 0)} answers of {CONE} are verified.",
        limits="One pivoting and one interior point method are timed: an interior point on the polygon's LCP would grow less "
        "with the facets. The corners of all polygons lie along the same first direction; turned polygons err differently. "
        "Large problems, on which a pivoting method ends early, are not included.",
        figures=(
            Figure(
                "ball",
                "A sliding ball with a side spin. Left: how far its path is from the parabola, across it. Right: the largest "
                "distance from the path with the cone against the number of facets; dotted: the order -2.",
                (
                    Panel("across the parabola, mm", partial(_paths, ball=ball)),
                    Panel("distance of the paths", partial(_distances, ball=ball)),
                ),
            ),
            Figure(
                "problems",
                "Spatial problems. Left: error of the velocity against the facets, each line a problem. Right: time of "
                "Lemke's method over that of the interior point on the cone.",
                (
                    Panel("error", partial(_errors, problems=problems)),
                    Panel("time over that with the cone", partial(_ratios, times=times)),
                ),
            ),
        ),
    )


def _times(solves: pd.DataFrame) -> pd.DataFrame:
    """Form, setup and solve, s, of each problem: with the cone and by the number of facets."""
    rows = solves[solves["verdict"].isin([*ACCEPTED, Verdict.RELAXED])]
    time = rows[["form_time", "setup_time", "solve_time"]].sum(axis=1)
    name = rows["variant"].str.extract(r"facets=(\d+)")[0].where(rows["variant"] != CONE, "cone")
    table = rows.assign(time=time, name=name).dropna(subset="name").pivot_table(index="problem", columns="name", values="time")
    return table[["cone", *sorted(set(table.columns) - {"cone"}, key=int)]]


def _dearer(ratio: pd.Series) -> str:
    """The fewest facets from which on the polygon always takes longer."""
    names = [name for name in ratio.index if name != "cone"]
    beyond = [name for k, name in enumerate(names) if (ratio[names[k:]] > 1).all()]
    return beyond[0] if beyond else f"more than {names[-1]}"


def _paths(ax: Axes, ball: pd.DataFrame) -> None:
    for k, row in enumerate(ball[ball["facets"].isin([0, 4, 6, 8, 16])].to_dict("records")):
        label = f"{row['facets']} facets" if row["facets"] else "cone"
        curve(ax, k, row["x"], 1000 * np.array(row["aside"]), label, marker="")
    finish(ax, "x, m", "mm")


def _distances(ax: Axes, ball: pd.DataFrame) -> None:
    polygons = ball[ball["facets"] > 0]
    curve(ax, 0, polygons["facets"], polygons["from_cone"])
    first = polygons.iloc[0]
    ax.plot(polygons["facets"], first["from_cone"] * (polygons["facets"] / first["facets"]) ** -2.0, color=INK, lw=0.6, ls=":")
    finish(ax, "facets", "m", "xy")


def _errors(ax: Axes, problems: pd.DataFrame) -> None:
    for k, (_, own) in enumerate(problems.groupby("number")):
        curve(ax, k, own["facets"], own["error"].clip(lower=KINK), f"{own['scene'].iloc[0]}, {own['contacts'].iloc[0]}")
    finish(ax, "facets", "error of the velocity", "xy")


def _ratios(ax: Axes, times: pd.DataFrame) -> None:
    ratio = times.drop(columns="cone").div(times["cone"], axis=0)
    facets = [int(name) for name in ratio.columns]
    for _, own in ratio.iterrows():
        ax.plot(facets, own, color=COLOURS[0], lw=0.4)
    curve(ax, 0, facets, ratio.median(), "median")
    ax.axhline(1, color=INK, lw=0.6, ls=":")
    finish(ax, "facets", "time ratio", "xy")
