"""Interior point methods on the friction LCP: success and speed, compared with the relaxation."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import FrictionProblem, first_problem, is_p0, relaxation_residual
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import COLOURS, INK
from frictionbench.solvers import one_start, solve
from studies.motions import thrown
from studies.study import Row, Study, Summary, Tables, curve, finish, listing, require, share, wilson

TOL, LIMIT, PATIENCE = 1e-8, 200, 12
FRICTIONS = (0.1, 0.3, 1.0, 3.0, 10.0)


def compared(problem: FrictionProblem) -> Row:
    """Which of three methods solve the problem, and their factorisations; with paths: predictor-corrector, then paths."""
    answers = {"plain": one_start(problem, TOL, LIMIT, PATIENCE), "paths": solve(problem, "interior_point", tol=TOL)}
    relaxed = solve(problem, "relaxation_ip", tol=TOL)
    found = {name: (fb.residual(problem, one.impulse) <= TOL, one) for name, one in answers.items()}
    found["relaxation"] = (relaxation_residual(problem, relaxed.impulse) <= TOL, relaxed)
    return {name: bool(solved) for name, (solved, _) in found.items()} | {
        f"{name}_work": one.work["factorisations"] if solved else None for name, (solved, one) in found.items()
    }


def random(frictions: Iterable[float] = FRICTIONS, contacts: Iterable[int] = (5, 15, 40), seeds: int = 15) -> Iterator[Row]:
    """Planar bodies that touch at random; friction: mu."""
    for friction, count, seed in product(frictions, contacts, range(seeds)):
        problem = fb.instance("random", contacts=count, friction=friction, seed=seed)
        yield {"friction": friction, "contacts": problem.contacts, "seed": seed, **compared(problem)}


def piles(frictions: Iterable[float] = (0.05, 0.2, 0.8), blocks: Iterable[int] = (1, 5, 20, 50, 100, 200)) -> Iterator[Row]:
    """Stacks on a slope whose lowest block is pushed; friction: mu; blocks: height of the stack."""
    for friction, count in product(frictions, blocks):
        problem = fb.scene("stack", blocks=count, friction=friction, push=1.0, slope=0.1).problem()
        yield {"friction": friction, "blocks": count, **compared(problem)}


def threshold(ratios: Iterable[float] = (0.25, 0.5, 0.9, 1.1, 2, 3, 4, 6), draws: int = 60) -> Iterator[Row]:
    """Random free velocities of a square block on two corners, of uniform direction in the metric of the kinetic energy."""
    for ratio in ratios:
        problem = first_problem(fb.scene("two_corner_block", friction=ratio))
        rows = [compared(one) for one in thrown(problem, draws, 0)]
        yield {
            "ratio": ratio,  # mu H/w
            "p0": is_p0(problem),  # whether the LCP has a P0 matrix
            "draws": draws,  # free velocities
            **{name: sum(row[name] for row in rows) for name in ("plain", "paths", "relaxation")},
        }


def summary(tables: Tables) -> Summary:
    random, piles, threshold = (tables[name] for name in ("random", "piles", "threshold"))
    below, beyond = threshold[threshold["p0"]], threshold[~threshold["p0"]]
    points = random.groupby(["friction", "contacts"])["plain"].agg(["sum", "count"])
    shares, worst = points.apply(lambda at: share(*at), axis=1), (points["sum"] / points["count"]).idxmin()
    ratio = (random["plain_work"] / random["relaxation_work"]).median()
    tall = piles[piles["blocks"] == piles["blocks"].max()]
    require((below["plain"] == below["draws"]).all(), "on the block all is solved where the matrix is P0")
    numbers = {
        "random": len(random),
        "random_relaxation": random["relaxation"].sum(),
        "random_paths": random["paths"].sum(),
        "points": len(points),
        "whole": int((points["sum"] == points["count"]).sum()),
        "worst": shares[worst],
        "worst_at": f"mu = {worst[0]:g} with {worst[1]} contacts",
        "draws": points["count"].iloc[0],
        "sizes": sorted(random["contacts"].unique()),
        "by_point": [(f"{mu:g}", *row) for mu, row in shares.unstack().iterrows()],  # noqa: PD010
        "ratio": f"{ratio:.2f}",
        "tallest": piles["blocks"].max(),
        "tall_least": f"{tall['plain_work'].min():.0f}",
        "tall_most": f"{tall['plain_work'].max():.0f}",
        "piles": f"{piles['plain'].sum()} of {len(piles)}",
        "p0_at": listing([f"{ratio:g}" for ratio in below["ratio"]]),
        "p0_share": share(below["plain"].iloc[0], below["draws"].iloc[0]),
        "beyond": listing([f"{share(row.plain, row.draws)} at {row.ratio:g}" for row in beyond.itertuples()]),
        "lost": int((beyond["draws"] - beyond["plain"]).sum()),
        "by_paths": int((beyond["paths"] - beyond["plain"]).sum()),
    }
    figures = {
        "shares": (
            Panel("random problems", partial(_random, points=points)),
            Panel("block on two corners", partial(_threshold, threshold=threshold)),
        ),
        "work": (Panel("height", partial(_height, piles=piles)),),
    }
    return Summary(numbers, figures)


def _random(ax: Axes, points: pd.DataFrame) -> None:
    for k, (size, at) in enumerate(points.groupby("contacts")):
        mu = at.index.get_level_values("friction").to_numpy(float)
        _with_intervals(ax, k, mu * (1 + 0.08 * (k - 1)), at["sum"], at["count"], f"{size} contacts")
    finish(ax, "mu", "share solved", "x")


def _threshold(ax: Axes, threshold: pd.DataFrame) -> None:
    ax.axvline(1, color=INK, lw=0.6, ls=":")
    _with_intervals(ax, 0, threshold["ratio"].to_numpy(float), threshold["plain"], threshold["draws"])
    finish(ax, "mu H/w", "share solved", "x")


def _with_intervals(ax: Axes, k: int, x: np.ndarray, solved: pd.Series, trials: pd.Series, label: str = "") -> None:
    value = (solved / trials).to_numpy(float)
    ends = np.array([wilson(int(s), int(n)) for s, n in zip(solved, trials, strict=True)])
    curve(ax, k, x, value, label)
    ax.vlines(x, *ends.T, lw=0.7, color=COLOURS[k])


def _height(ax: Axes, piles: pd.DataFrame) -> None:
    for k, (friction, group) in enumerate(piles.groupby("friction")):
        curve(ax, k, group["blocks"], group["plain_work"], f"mu = {friction:g}, Coulomb", ls="-")
        curve(ax, k, group["blocks"], group["relaxation_work"], f"mu = {friction:g}, relaxation", ls=":")
    finish(ax, "blocks", "factorisations", "x")


STUDY = Study((random, piles, threshold), summary)
