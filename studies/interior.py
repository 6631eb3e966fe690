"""Interior point on the friction LCP itself: how often and how fast, beside the relaxation, and paths that fold."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import compress, product

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import LCP, FrictionProblem, census, first_problem, is_p0, relaxation_residual
from frictionbench.reports import INK, Panel
from frictionbench.solvers import one_start, solve
from studies.motions import thrown
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, share, wilson

METHODS = {"plain": "Coulomb, predictor-corrector", "paths": "Coulomb, then paths", "relaxation": "relaxation"}
TOL, LIMIT, PATIENCE = 1e-8, 200, 12
END = 1e-4  # t at which a path is near enough to its end
FRICTIONS = (0.1, 0.3, 1.0, 3.0, 10.0)


def compared(problem: FrictionProblem) -> Row:
    """Which of the three methods solve the problem, with their factorisations; with paths: predictor-corrector, then paths."""
    answers = {"plain": one_start(problem, TOL, LIMIT, PATIENCE), "paths": solve(problem, "interior_point", tol=TOL)}
    relaxed = solve(problem, "relaxation_ip", tol=TOL)
    found = {name: (fb.residual(problem, one.impulse) <= TOL, one) for name, one in answers.items()}
    found["relaxation"] = (relaxation_residual(problem, relaxed.impulse) <= TOL, relaxed)
    return {name: bool(solved) for name, (solved, _) in found.items()} | {
        f"{name}_work": one.work["factorisations"] if solved else None for name, (solved, one) in found.items()
    }


def random(frictions: Iterable[float] = FRICTIONS, contacts: Iterable[int] = (5, 15, 40), seeds: int = 15) -> Iterator[Row]:
    """Planar bodies that touch at random.

    friction: mu.
    """
    for friction, count, seed in product(frictions, contacts, range(seeds)):
        problem = fb.instance("random", contacts=count, friction=friction, seed=seed)
        yield {"friction": friction, "contacts": problem.contacts, "seed": seed, **compared(problem)}


def piles(frictions: Iterable[float] = (0.05, 0.2, 0.8), blocks: Iterable[int] = (1, 5, 20, 50, 100, 200)) -> Iterator[Row]:
    """Stacks on a slope whose lowest block is pushed.

    friction: mu; blocks: height of the stack.
    """
    for friction, count in product(frictions, blocks):
        problem = fb.scene("stack", blocks=count, friction=friction, push=1.0, slope=0.1).problem()
        yield {"friction": friction, "blocks": count, **compared(problem)}


def threshold(ratios: Iterable[float] = (0.25, 0.5, 0.9, 1.1, 2, 3, 4, 6), draws: int = 60) -> Iterator[Row]:
    """Random free velocities of a square block on two corners, of uniform direction in the metric of the kinetic energy."""
    for ratio in ratios:
        problem = first_problem(fb.scene("two_corner_block", friction=ratio))
        blocks = thrown(problem, draws, 0)
        rows = [compared(one) for one in blocks]
        yield {
            "ratio": ratio,  # mu H/w
            "p0": is_p0(problem),  # whether the LCP has a P0 matrix
            "draws": draws,  # free velocities
            "several": sum(census(one).velocity_count != 1 for one in blocks),  # how many have several velocities as solutions
            **{name: sum(row[name] for row in rows) for name in ("plain", "paths", "relaxation")},
            # median factorisations of the predictor-corrector where it solves
            "plain_work": float(np.median([row["plain_work"] for row in rows if row["plain"]] or [np.nan])),
        }


def path(frictions: Iterable[float] = (1.0, 10.0), contacts: int = 5, seeds: Iterable[int] = range(16)) -> Iterator[Row]:
    """Central paths of random problems: of each friction the one that turns most often of those that arrive.

    friction: mu; length: of the path so far, in logarithms; t: z_i w_i, 1 at the start.
    """
    for friction in frictions:
        problems = [fb.instance("random", contacts=contacts, friction=friction, seed=seed) for seed in seeds]
        traced = [central_path(problem.lcp()) for problem in problems]
        trapped = [fb.residual(problem, one_start(problem, TOL, LIMIT, PATIENCE).impulse) > TOL for problem in problems]
        arrived = [points[-1][1] <= END for points in traced]
        folded = [bool(arrives and folds(points)) for arrives, points in zip(arrived, traced, strict=True)]
        counts = {
            "traced": len(traced),  # paths traced with this friction; this one turns most often of those that arrive
            "arrived": sum(arrived),  # how many reach t = 0.0001 in 600 steps
            "folded": sum(folded),  # how many of these turn
            "trapped": sum(trapped),  # on how many of these problems the predictor-corrector is trapped
            "both": sum(map(all, zip(trapped, folded, strict=True))),  # on how many both
        }
        for length, t in max(compress(traced, arrived), key=folds):
            yield {"friction": friction, "length": length, "t": t, **counts}


def folds(points: list[tuple[float, float]]) -> int:
    """How often t turns along a path."""
    return int(np.sum(np.diff(np.sign(np.diff([t for _, t in points]))) != 0))


def central_path(lcp: LCP, most: int = 600, length: float = 0.2) -> list[tuple[float, float]]:
    """The path z_i w_i = t, w - M z - q = t (e - M e - q) from z = w = e at t = 1, as (arc length, t), until t <= END.

    With a = log z and c = log t it is the curve G(a, c) = e^(c - a) - M e^a - q - e^c (e - M e - q) = 0, followed by its length
    in (a, c): a step along the tangent, Newton's method back by least squares, and half the step where that fails.
    """
    M, q = lcp.dense, lcp.q / np.abs(lcp.q).max()
    start = 1 - M.sum(axis=1) - q

    def defect(x: Array) -> tuple[Array, Array]:
        z, t = np.exp(x[:-1]), np.exp(x[-1])
        return t / z - M @ z - q - t * start, np.column_stack([-np.diag(t / z) - M * z, t / z - t * start])

    x, way, points, total = np.zeros(len(q) + 1), -np.eye(len(q) + 1)[-1], [(0.0, 1.0)], 0.0
    while len(points) < most and points[-1][1] > END:
        tangent = np.linalg.svd(defect(x)[1])[2][-1]
        tangent *= np.sign(tangent @ way)
        step = length
        while step > 1e-6:
            trial = x + step * tangent
            for _ in range(6):
                value, slope = defect(trial)
                trial = trial - np.linalg.lstsq(slope, value, rcond=None)[0]
            near = np.linalg.norm(trial - x) < 1.5 * step and (trial - x) @ tangent > 0.7 * np.linalg.norm(trial - x)
            if near and np.abs(defect(trial)[0]).max() < 1e-9 * max(1.0, np.exp(np.abs(trial).max())):
                break
            step /= 2
        else:
            break
        total += float(np.linalg.norm(trial - x))
        way, x = trial - x, trial
        points.append((total, float(np.exp(x[-1]))))
    return points


def summary(found: Tables) -> Summary:
    random, piles, threshold, path = (found[name] for name in ("random", "piles", "threshold", "path"))
    below, beyond = threshold[threshold["p0"]], threshold[~threshold["p0"]]
    everywhere = below["plain"].sum() == below["draws"].sum()
    modest, wide = random[random["friction"] <= 1], random[random["friction"] > 1]
    ratio = (random["plain_work"] / random["relaxation_work"]).median()
    tall = piles[piles["blocks"] == piles["blocks"].max()]
    groups = path.groupby("friction")[["traced", "arrived", "folded", "trapped", "both"]].first()
    last = groups.iloc[-1]
    numbers = {
        "random_plain": share(random["plain"].sum(), len(random)),
        "random_relaxation": random["relaxation"].sum(),
        "random_paths": random["paths"].sum(),
        "modest": share(modest["plain"].sum(), len(modest)),
        "most_friction": f"{random['friction'].max():g}",
        "wide": share(wide["plain"].sum(), len(wide)),
        "ratio": f"{ratio:.2f}",
        "tallest": piles["blocks"].max(),
        "tall_least": f"{tall['plain_work'].min():.0f}",
        "tall_most": f"{tall['plain_work'].max():.0f}",
        "piles_solved": piles["plain"].sum(),
        "piles": len(piles),
        "p0_solved": everywhere,
        "p0_draws": below["draws"].sum(),
        "p0_share": share(below["plain"].sum(), below["draws"].sum()),
        "lost": int((beyond["draws"] - beyond["plain"]).sum()),
        "beyond": beyond["draws"].sum(),
        "by_paths": int((beyond["paths"] - beyond["plain"]).sum()),
        "traced": f"{last['traced']:.0f}",
        "mu": f"{groups.index[-1]:g}",
        "arrived": f"{last['arrived']:.0f}",
        "folded": f"{last['folded']:.0f}",
        "low_mu": f"{groups.index[0]:g}",
        "low_arrived": f"{groups['arrived'].iloc[0]:.0f}",
        "low_folded": f"{groups['folded'].iloc[0]:.0f}",
        "trapped": f"{last['trapped']:.0f}",
        "both": f"{last['both']:.0f}",
        "differ": last["both"] < max(last["trapped"], last["folded"]),
    }
    figures = {
        "shares": (
            Panel("random problems", partial(_random, random=random)),
            Panel("block on two corners", partial(_threshold, threshold=threshold)),
        ),
        "work": (Panel("height", partial(_height, piles=piles)), Panel("central paths", partial(_path, path=path))),
    }
    return Summary(numbers, figures)


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


STUDY = Study((random, piles, threshold, path), summary)
