"""The study of interior point methods on the friction problem itself."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import curve, finish
from frictionbench.reports.studies.numbers import share, wilson
from frictionbench.results.studies import StudyTables

METHODS = {"plain": "Coulomb, predictor-corrector", "paths": "Coulomb, then paths", "relaxation": "relaxation"}


def account(found: StudyTables) -> Account:
    random, piles, threshold, path = (found[name] for name in ("random", "piles", "threshold", "path"))
    below, beyond = threshold[threshold["p0"]], threshold[~threshold["p0"]]
    everywhere = below["plain"].sum() == below["draws"].sum()
    modest, wide = random[random["friction"] <= 1], random[random["friction"] > 1]
    ratio = (random["plain_work"] / random["relaxation_work"]).median()
    tall = piles[piles["blocks"] == piles["blocks"].max()]
    groups = path.groupby("friction")[["traced", "arrived", "folded", "trapped", "both"]].first()
    last = groups.iloc[-1]
    return Account(
        answer=f"Yes, in the plane: from one start it solves {share(int(random['plain'].sum()), len(random))} of random "
        f"problems, the relaxation's {int(random['relaxation'].sum())}; with paths after it {int(random['paths'].sum())}.",
        result=f"Up to mu = 1 the predictor-corrector alone solves {share(int(modest['plain'].sum()), len(modest))}, and "
        f"beyond, up to mu = {random['friction'].max():g}, {share(int(wide['plain'].sum()), len(wide))}. Where both solve, it "
        f"takes {ratio:.2f} times the relaxation's factorisations in the median. Height costs little: stacks of "
        f"{piles['blocks'].max()} blocks take {tall['plain_work'].min():.0f} to {tall['plain_work'].max():.0f} factorisations, "
        f"and {int(piles['plain'].sum())} of {len(piles)} stacks are solved. On the block "
        + (
            f"no draw fails where the matrix is P0 ({int(below['draws'].sum())} draws), and beyond the threshold "
            if everywhere
            else f"{share(int(below['plain'].sum()), int(below['draws'].sum()))} are solved where the matrix is P0, and beyond "
        )
        + f"{int((beyond['draws'] - beyond['plain']).sum())} of {int(beyond['draws'].sum())} do, of which "
        f"{int((beyond['paths'] - beyond['plain']).sum())} are solved by following paths. "
        f"Central paths of {last['traced']:.0f} small problems with mu = {groups.index[-1]:g} were traced: "
        f"{last['arrived']:.0f} arrive and {last['folded']:.0f} of these turn back in t on the way; with mu = "
        f"{groups.index[0]:g} {groups['arrived'].iloc[0]:.0f} arrive and {groups['folded'].iloc[0]:.0f} turn. The "
        f"predictor-corrector is trapped on {last['trapped']:.0f} of those with the larger mu, "
        f"{last['both']:.0f} of which have such a path"
        + (": a fold and a trap are not the same." if last["both"] < max(last["trapped"], last["folded"]) else "."),
        limits="One start, one rule of steps and one regularisation were tried, those of this project's solver; others may be "
        "trapped elsewhere. The central path depends on its start, and the one traced is not the solver's. No theory is "
        "confirmed beyond P0: that a method succeeds on these problems proves nothing of others. Problems in space are not "
        "treated.",
        figures=(
            Figure(
                "shares",
                "Share of problems solved to 1e-8 with 95 % intervals. Left: random problems over mu. Right: a block on two "
                "corners over mu H/w; its matrix is P0 left of the dotted line.",
                (
                    Panel("random problems", partial(_random, random=random)),
                    Panel("block on two corners", partial(_threshold, threshold=threshold)),
                ),
            ),
            Figure(
                "work",
                "Left: factorisations against the height of a stack, a line for each mu and method. Right: t along central "
                "paths; of each mu the path that turns most often of those that arrive.",
                (
                    Panel("height", partial(_height, piles=piles)),
                    Panel("central paths", partial(_path, path=path)),
                ),
            ),
        ),
    )


def _random(ax: Axes, random: pd.DataFrame) -> None:
    for k, (name, label) in enumerate(METHODS.items()):
        table = random.groupby("friction")[name].agg(["sum", "count"])
        _with_intervals(ax, k, table.index.to_numpy(float) * (1 + 0.08 * (k - 1)), table["sum"], table["count"], label)
    finish(ax, "mu", "share solved", "x")


def _threshold(ax: Axes, threshold: pd.DataFrame) -> None:
    ax.axvline(1, color=INK, lw=0.6, ls=":")
    for k, (name, label) in enumerate(METHODS.items()):
        at = threshold["ratio"].to_numpy(float) * (1 + 0.04 * (k - 1))
        _with_intervals(ax, k, at, threshold[name], threshold["draws"], label)
    finish(ax, "mu H/w", "share solved", "x")


def _with_intervals(ax: Axes, k: int, x: np.ndarray, solved: pd.Series, trials: pd.Series, label: str) -> None:
    value = (solved / trials).to_numpy(float)
    ends = np.array([wilson(int(s), int(n)) for s, n in zip(solved, trials, strict=True)])
    curve(ax, k, x, value, label)
    for at, (low, high) in zip(x, ends, strict=True):
        curve(ax, k, [at, at], [low, high], lw=0.7, marker="", ls="-")


def _height(ax: Axes, piles: pd.DataFrame) -> None:
    for k, (friction, own) in enumerate(piles.groupby("friction")):
        curve(ax, k, own["blocks"], own["plain_work"], f"mu = {friction:g}, Coulomb", ls="-")
        curve(ax, k, own["blocks"], own["relaxation_work"], f"mu = {friction:g}, relaxation", ls=":")
    finish(ax, "blocks", "factorisations", "x")


def _path(ax: Axes, path: pd.DataFrame) -> None:
    for k, (friction, own) in enumerate(path.groupby("friction")):
        curve(ax, k, own["length"], own["t"], f"mu = {friction:g}", marker="")
    finish(ax, "length of the path", "t", "y")
