"""How many motions has a step, which of them is found, and what does a digit of residual bring?"""

import json
from collections.abc import Iterator
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import FrictionProblem, refined, velocity_distance
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.solvers import solve
from studies.motions import problem_of
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, listing, order, require

TOL = 1e-8
SAME = 1e-8  # relative to the change by contact: refined answers are nearer or farther apart by orders of magnitude
STARTS = 3  # random starts of the methods that take one
LADDER = tuple(10.0**-k for k in range(1, 13))
FRICTIONS = (0.1, 0.3, 0.5, 0.8, 1.2, 2.0, 5.0)
SCENES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("disc_pile", {"rows": 5, "push": 0.1}),
    ("disc_pile", {"rows": 10, "push": 0.1}),
    ("wall", {"rows": 5, "columns": 5, "push": 1.0}),
    ("pyramid", {"rows": 8, "push": 1.0}),
    ("arch", {"stones": 15, "push": 0.1}),
    ("chain", {"links": 20}),
    *(("random", {"contacts": 40, "bodies": 20, "seed": seed}) for seed in range(3)),
    *(("random_bodies", {"contacts": 40, "seed": seed}) for seed in range(3)),
    ("random_bodies", {"contacts": 150, "seed": 0}),
    ("cubes", {"boxes": 5}),
    ("sphere_pyramid", {"levels": 4, "noise": 0.03}),
    *(("packed_spheres", {"spheres": 30, "seed": seed}) for seed in range(2)),
    ("box_wall", {"rows": 3, "bricks": 3}),
)
METHODS = {2: ("lemke", "path_search", "interior_point", "nsgs"), 3: ("interior_point", "proximal_newton", "nsgs")}
WARM = ("nsgs", "proximal_newton")


def answers(scenes: Any = SCENES, frictions: Any = FRICTIONS, starts: int = STARTS) -> Iterator[Row]:
    """Every method's answer to the same problem, refined to rounding level, and the outcome to which it belongs."""
    for name, settings in scenes:
        for friction in frictions:
            problem = problem_of(name, settings | {"friction": friction})
            outcomes: list[Array] = []
            for method, start, finest in found(problem, starts):
                apart = [] if finest is None else [velocity_distance(problem, finest, each) or 0.0 for each in outcomes]
                nearest = min(apart, default=np.inf)
                if finest is not None and nearest > SAME:
                    outcomes.append(finest)
                outcome = apart.index(nearest) if nearest <= SAME else len(outcomes) - 1
                yield {
                    "scene": name,
                    "settings": json.dumps(settings),  # but for friction
                    "friction": friction,
                    "dimension": problem.dimension,
                    "contacts": problem.contacts,
                    "method": method,
                    "start": start,  # zero, or the seed of a random start
                    "outcome": outcome if finest is not None else -1,  # numbered in the order found; -1 without an answer
                    "distance": (apart[0] if apart else 0.0) if finest is not None else np.nan,  # from the first outcome
                    "nearest": nearest if apart else np.nan,  # the least distance from the outcomes found before
                }


def found(problem: FrictionProblem, starts: int) -> Iterator[tuple[str, str, Array | None]]:
    """Yield the refined answers of all methods, from zero and from random starts; None without one within the work limit."""
    random = np.random.default_rng(1)
    scale = problem.units / problem.scale
    for method in METHODS[problem.dimension]:
        for seed in range(1 + starts * (method in WARM)):
            start = None
            if seed:
                start = scale[:, None] * random.standard_normal((problem.contacts, problem.dimension))
                start[:, 0] = np.abs(start[:, 0])
            answer = solve(problem, method, tol=TOL, start=start)
            solved = answer.status is fb.Status.SOLVED
            yield method, str(seed) if seed else "zero", refined(problem, answer.impulse) if solved else None


def digits(scenes: Any = SCENES, frictions: Any = (0.3, 0.8), ladder: Any = LADDER) -> Iterator[Row]:
    """Residual and velocity error of answers at a ladder of tolerances, v* shared by two refined methods."""
    for name, settings in scenes:
        for friction in frictions:
            problem = problem_of(name, settings | {"friction": friction})
            finest = [r for *_, r in found(problem, 0) if r is not None]
            if len(finest) < 2 or any((velocity_distance(problem, r, finest[0]) or 0.0) > SAME for r in finest[1:]):
                continue
            for method in METHODS[problem.dimension]:
                for tol in ladder:
                    answer = solve(problem, method, tol=tol)
                    yield {
                        "scene": name,
                        "friction": friction,
                        "dimension": problem.dimension,
                        "method": method,
                        "tol": tol,
                        "residual": fb.residual(problem, answer.impulse),
                        "error": velocity_distance(problem, answer.impulse, finest[0]),
                    }


PROBLEM = ["scene", "settings", "friction"]


def summary(tables: Tables) -> Summary:
    rows, ladder = tables["answers"], tables["digits"]
    known = rows[rows["outcome"] >= 0]
    problems = known.groupby(PROBLEM).agg(
        dimension=("dimension", "first"),
        contacts=("contacts", "first"),
        outcomes=("outcome", lambda group: group.max() + 1),
        apart=("distance", "max"),
    )
    several = problems[problems["outcomes"] > 1]
    require(len(several), "some problems have several outcomes")
    equal = known["nearest"] <= SAME
    below, above = known["nearest"][equal].max(), known["nearest"][~equal].min()
    require(below < SAME / 100 and above > SAME * 10, "answers are much nearer than the threshold, or farther apart")
    where = several.reset_index().groupby("scene")["friction"].unique()
    every = known[known["start"] == "zero"]
    cold = every.merge(several.reset_index()[PROBLEM])
    agreeing = _agreements(cold)
    measured = ladder[(ladder["residual"] < 0.1) & (ladder["residual"] > 1e-11) & (ladder["error"] > 0)]
    gains = []  # by method
    for (dimension, name), group in measured.groupby(["dimension", "method"]):
        gain, power = group["error"] / group["residual"], order(group["residual"], group["error"]).value
        cells = (f"{power:.2f}", f"{gain.median():.1f}", f"{gain.max():.0f}")
        gains.append(("the plane" if dimension == 2 else "space", name, len(group), *cells))
    numbers = {
        "problems": len(problems),
        "several": len(several),
        "by_friction": [
            (f"{mu:g}", *(f"{(group > 1).sum()} of {group.size}" for _, group in rows.groupby("dimension")["outcomes"]))
            for mu, rows in problems.groupby("friction")
        ],
        "by_size": [
            ("above" if large else "up to", f"{(part['outcomes'] > 1).sum()} of {len(part)}", f"{part['apart'].max():.2g}")
            for large, part in problems.groupby(problems.index.get_level_values("friction") > 0.8)
        ],
        "below": f"{below:.0e}",
        "above": f"{above:.0e}",
        "most": several["outcomes"].max(),
        "median": f"{several['apart'].median():.2g}",
        "largest": problems["contacts"].max(),
        "solves": len(rows),
        "missed": len(rows) - len(known),
        "missing": listing([f"{name} ({n})" for name, n in rows[rows["outcome"] < 0].groupby("method").size().items()]),
        "where": listing([f"{name} (mu = {', '.join(f'{mu:g}' for mu in sorted(mus))})" for name, mus in where.items()]),
        "never": listing(sorted(set(problems.reset_index()["scene"]) - set(where.index))),
        "differ": int((cold.groupby(PROBLEM)["outcome"].max() > cold.groupby(PROBLEM)["outcome"].min()).sum()),
        "agreements": [(*pair, share, agreeing.get(pair, "–")) for pair, share in _agreements(every).items()],
        "offered": int(problems.index.isin(ladder["friction"].unique(), level="friction").sum()),
        "agreeing": int((ladder["method"].eq("nsgs") & ladder["tol"].eq(ladder["tol"].max())).sum()),  # nsgs answers each
        "answers": len(measured),
        "slopes": f"{min(row[3] for row in gains)} to {max(row[3] for row in gains)}",
        "gains": gains,
    }
    figures = {
        name: tuple(
            Panel(f"in {where}", partial(draw, rows=shown[shown["dimension"] == dimension]))
            for dimension, where in ((2, "the plane"), (3, "space"))
        )
        for name, draw, shown in (("digits", _draw_digits, measured), ("apart", _draw_apart, several.reset_index()))
    }
    return Summary(numbers, figures)


def _agreements(cold: pd.DataFrame) -> dict[tuple[str, str], str]:
    """Return where and for which two methods, started from zero, on how many problems that both solve their outcomes agree."""
    agreements = {}
    for dimension, where in ((2, "the plane"), (3, "space")):
        table = cold[cold["dimension"] == dimension].pivot_table(index=PROBLEM, columns="method", values="outcome")
        for one, other in combinations(table.columns, 2):
            both = table[[one, other]].dropna()
            agreements[where, f"{one} and {other}"] = f"{(both[one] == both[other]).sum()} of {len(both)}"
    return agreements


def _draw_digits(ax: Axes, rows: pd.DataFrame) -> None:
    ax.plot([1e-11, 1e-1], [1e-11, 1e-1], color=INK, lw=0.8, ls=":")
    for k, (name, group) in enumerate(rows.groupby("method")):
        curve(ax, k, group["residual"], group["error"], str(name), ls="", alpha=0.6)
    finish(ax, "residual", "velocity error", "xy")


def _draw_apart(ax: Axes, rows: pd.DataFrame) -> None:
    for k, (name, group) in enumerate(rows.groupby("scene")):
        curve(ax, k, group["friction"], group["apart"], str(name), ls="")
    finish(ax, "friction", "largest distance", "xy")


STUDY = Study((answers, digits), summary)
