"""The study of maximum dissipation with several contacts."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import COLOURS, finish
from frictionbench.reports.studies.numbers import listing, share
from frictionbench.results.studies import StudyTables

ROUNDING = 1e-6  # of the free motion's energy


def account(found: StudyTables) -> Account:
    solutions, returned = found["solutions"], found["returned"]
    gap = (solutions["energy"] - solutions["least"]).abs().max()
    found.require(solutions["residual"].max() < 1e-7, "all listed solutions are solutions")
    found.require(gap < ROUNDING, "every solution dissipates most for its own normal impulses")
    problems = solutions.groupby("number").first()
    ties = solutions.groupby("number")["energy"].apply(lambda energies: np.diff(np.sort(energies)).min())
    answered = returned[returned["rank"].notna()]
    first = answered.assign(first=answered["rank"] == 1).groupby("solver")["first"].agg(["sum", "count"])
    order = (first["sum"] / first["count"]).sort_values(ascending=False)
    never = [str(name) for name in order.index if order[name] == 0]
    silent = int(returned["rank"].isna().sum())
    ranks = sorted(answered["rank"].astype(int).unique())
    counts = [str(count) for count in sorted(problems["of"].unique())]
    best, worst = order.index[0], order.index[-1]
    return Account(
        answer="No. Every one of the solutions dissipates most for its own normal impulses, so the principle rejects none; "
        f"the solution of least energy is in {first['sum'].sum() / first['count'].sum():.0%} of the answers, which come from "
        f"{len(order) - len(never)} of {len(order)} solvers.",
        result=f"{len(problems)} problems have {listing(counts, 'or')} isolated solutions. With its "
        f"normal impulses given, friction within all cones together can leave no less energy than each solution does, to "
        f"{gap:.0e} of the free motion's energy: by the conditions of optimality the joint principle and that of each contact "
        "are one, and what differs is the normal impulses. Energy could select one nevertheless, since the solutions of one "
        f"problem differ by at least {ties.min():.0e} of it. Solvers do not look for it: least energy is returned most often "
        f"by {best} ({share(int(first.loc[best, 'sum']), int(first.loc[best, 'count']))}) and least often by {worst} "
        f"({share(int(first.loc[worst, 'sum']), int(first.loc[worst, 'count']))})"
        + (f"; never by {listing(never)}" if len(never) > 1 else "")
        + f". All ranks from {ranks[0]} to {ranks[-1]} are met. {silent} of {len(returned)} answers are none of the listed "
        "solutions to 1e-8.",
        limits="Two kinds of problems with one or two contacts, in the plane; with more contacts solutions were not counted. "
        "Which solution a solver returns depends on its start and scaling, here its defaults: the shares describe habits, not "
        "properties of methods. That solvers should return the solution of least energy is not claimed: for the rod the open "
        "solution, which leaves the most energy, obeys the same law.",
        figures=(
            Figure(
                "energies",
                "Left: the energy that each solution leaves, a column for each problem. Right: how often each solver returns "
                "which, by its rank; white: no listed solution.",
                (
                    Panel("energy of the solutions", partial(_energies, solutions=solutions)),
                    Panel("returned", partial(_returned, returned=returned)),
                ),
            ),
        ),
    )


def _energies(ax: Axes, solutions: pd.DataFrame) -> None:
    for rank, own in solutions.groupby("rank"):
        ax.plot(own["number"], own["energy"], "o", color=COLOURS[int(rank) - 1], ms=3, label=f"rank {rank}")
    finish(ax, "problem", "energy left, share")


def _returned(ax: Axes, returned: pd.DataFrame) -> None:
    table = returned.assign(rank=returned["rank"].fillna(0)).pivot_table(
        index="solver", columns="rank", values="number", aggfunc="count", fill_value=0
    )
    table = table.div(table.sum(axis=1), axis=0)
    left = np.zeros(len(table))
    for rank in sorted(table.columns):
        colour = COLOURS[int(rank) - 1] if rank else "none"
        ax.barh(
            table.index, table[rank], left=left, color=colour, edgecolor=INK, lw=0.3, label=f"rank {rank:g}" if rank else "_"
        )
        left += table[rank].to_numpy(float)
    finish(ax, "share of problems", "", xlim=(0, 1))
