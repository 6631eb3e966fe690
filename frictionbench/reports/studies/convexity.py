"""The study of solution sets: how often, and where, they are not convex."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM, GRID, INK
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.heat import heat
from frictionbench.reports.studies.numbers import listing, share
from frictionbench.results.studies import StudyTables

BLUE = "#0077bb"
ROUNDING = 1e-12  # residuals below it are rounding


def account(found: StudyTables) -> Account:
    jam, block, motions, scenes = (found[name] for name in ("jam", "block", "motions", "scenes"))
    inside, beyond = jam[jam["share"] <= 1], jam[jam["share"] > 1]
    found.require(jam["residual"].max() < ROUNDING, "the closed form solves the jam")
    found.require(inside["middle_residual"].max() < ROUNDING, "the sliding solutions of the jam form a segment")
    found.require((beyond["middle_residual"] > 1e-3).all(), "no middle with a sticking solution is a solution")
    bent = scenes[scenes["impulses"].isin(["not convex", "isolated"])]
    loose = scenes[(scenes["velocities"] != "one") & scenes["pointed"] & scenes["p0"]]
    several = block[block["several_velocities"] > 0]
    found.require(not several["p0"].any(), "a block with a P0 matrix has one velocity")
    high = block.loc[(block["several_velocities"] / block["draws"]).idxmax()]
    least = (several["friction"] * several["aspect"]).min()
    listed, odd = motions["listed"].sum(), (motions["isolated"] + motions["not_convex"]).sum()
    many = int(motions["several_velocities"].sum())
    far = beyond.iloc[-1]
    names = sorted({*bent["scene"]})
    return Account(
        answer=f"No. The jam's solutions are a bent line, and a block on two corners has up to "
        f"{block['most_velocities'].max()} isolated ones; among {listed} problems of simulated and recorded motions "
        f"{odd or 'none'} {'was' if odd <= 1 else 'were'} of either kind.",
        result=f"In the jam, impulses from none to those that just stop the disc form a segment; then a ray of larger ones "
        f"begins. All {len(jam)} points of the closed form are solutions, to a residual of {jam['residual'].max():.0e}. The "
        f"middle of no impulse and of {far['share']:g} times the stopping one is none: its residual is "
        f"{far['middle_residual']:.2f}, and its gap z'w is {far['middle_gap']:.3g} m V^2. Of {len(scenes)} scenes with few "
        f"contacts {len(bent)} have such a set: {listing(names)}. "
        f"The block has several velocities only where its matrix is not P0, from mu H/w = {least:.3g} on in this grid, most "
        f"often at mu = {high['friction']:.3g} and H/w = {high['aspect']:g}: "
        f"{share(int(high['several_velocities']), int(high['draws']))} of the random velocities. "
        f"In motions, all solutions were listed of {listed} of {motions['problems'].sum()} problems: of {motions['one'].sum()} "
        f"the impulses are unique, of {motions['convex'].sum()} a convex set, as hyperstatic contacts make it, of {odd} not "
        f"convex or isolated; {many or 'none'} of them {'has' if many <= 1 else 'have'} more than one velocity."
        + (
            f" More than one velocity does not need a matrix that is not P0: {listing(sorted({*loose['scene']}))}."
            if len(loose)
            else ""
        ),
        limits="Nothing is said of problems in space, nor of larger ones: the cost of listing grows by four with each contact. "
        "The shares of the block belong to free velocities of uniform direction in the metric of the kinetic energy. The "
        "motions are those of one scheme and one solver, which avoids by its choice some problems that another would meet.",
        figures=(
            Figure(
                "jam",
                "Left: the solutions of the jam; right: the residual of the middle between each and no impulse.",
                (
                    Panel("the solutions", partial(_bent, jam=jam)),
                    Panel("their middles with no impulse", partial(_middles, jam=jam)),
                ),
            ),
            Figure(
                "block",
                "Per cent of random velocities for which a block on two corners has solutions with different velocities. "
                "Left of the dashed line the matrix is P0.",
                (Panel("block on two corners", partial(_shares, block=block)),),
                columns=1,
            ),
        ),
    )


def _bent(ax: Axes, jam: pd.DataFrame) -> None:
    slides = jam["share"] <= 1
    ax.plot(jam["normal"][slides], jam["velocity"][slides], color=BLUE, label="slides")
    ax.plot(jam["normal"][~slides], jam["velocity"][~slides], color=BLUE, ls="--", label="sticks, any larger impulse")
    first, last = jam.iloc[0], jam.iloc[-1]
    ax.plot(*zip(first[["normal", "velocity"]], last[["normal", "velocity"]], strict=True), color=ALARM, lw=0.7, ls=":")
    middle = (first[["normal", "velocity"]] + last[["normal", "velocity"]]) / 2
    ax.plot(*middle, "x", color=ALARM, label="no solution")
    ax.set(xlabel="normal impulse, N s", ylabel="velocity afterwards, m/s")
    ax.grid(**GRID)
    ax.legend()


def _middles(ax: Axes, jam: pd.DataFrame) -> None:
    ax.plot(jam["share"], jam["middle_residual"], color=BLUE, label="residual")
    ax.plot(jam["share"], jam["middle_gap"], color=INK, ls="--", label="z'w / (m V^2)")
    ax.set(xlabel="normal impulse over the stopping one", ylabel="of the middle")
    ax.grid(**GRID)
    ax.legend()


def _shares(ax: Axes, block: pd.DataFrame) -> None:
    heat(ax, block.assign(share=block["several_velocities"] / block["draws"]), "friction", "aspect", "share")
    edge = np.repeat(block.groupby("aspect")["p0"].sum() - 0.5, 2)
    ax.plot(edge, np.repeat(np.arange(-0.5, len(edge) / 2), 2)[1:-1], color=INK, ls="--")
    ax.set(xlabel="mu", ylabel="height over width")
