"""What do sweeps cost and reach in single precision? Residual against time on steps of robots, by method."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product
from time import thread_time

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.harness.plans import robots
from frictionbench.reports.drawing.figures import Panel
from frictionbench.solvers import find
from studies.study import Row, Study, Summary, Tables, curve, finish, listing, require

METHODS = ("nsgs", "apgd_coulomb", "admm_coulomb")
PRECISIONS = {"double": "", "single": "[precision=single]"}
LIMITS = (10, 20, 50, 100, 200, 500, 1000, 2000)
UNREACHED, REPEATS = 1e-300, 3  # a tolerance that no method reaches, so that only the work limit ends it
TARGETS = (1e-4, 1e-6)


def rounded(cases: Iterable[str] | None = None) -> Iterator[Row]:
    """For a step of each model, the residual of an exact answer on the problem with data rounded to single precision."""
    for case in _cases(cases):
        problem = fb.instance("robot_step", case=case)
        parts = {name: getattr(problem, name) for name in ("mass", "normal", "tangent", "friction", "free_velocity", "bias")}
        nearby = problem.replace(**{name: part.astype(np.float32).astype(float) for name, part in parts.items()})
        yield {"case": case, "residual": fb.residual(problem, fb.solve(nearby, "hybrid", tol=1e-12).impulse)}


def reached(cases: Iterable[str] | None = None, limits: Iterable[int] = LIMITS) -> Iterator[Row]:
    """The verified residual and the least time (s, with form and setup) for each limit on sweeps or iterations."""
    for case, method, limit, precision in product(_cases(cases), METHODS, limits, PRECISIONS):
        _, solver = find(method + PRECISIONS[precision])
        problem, times = fb.instance("robot_step", case=case), []
        solver.solve(solver.prepare(problem.fresh()), UNREACHED, 1)  # compiles
        for _ in range(REPEATS):
            begun = thread_time()
            answer = solver.solve(solver.prepare(problem.fresh()), UNREACHED, limit)
            times.append(thread_time() - begun)
        found = {"residual": fb.residual(problem, answer.impulse), "seconds": min(times)}
        yield {"case": case, "contacts": problem.contacts, "method": method, "precision": precision, "limit": limit, **found}


def _cases(cases: Iterable[str] | None) -> list[str]:
    """Return the cases, by default the step of each model in the suite `standard`."""
    return list(cases or [source.parameters["case"] for source in robots.one_of_each()])


def summary(tables: Tables) -> Summary:
    table, rounding = tables["reached"], tables["rounded"]["residual"]
    least = table.groupby(["method", "precision", "case"])["residual"].min()
    coarse = (least <= TARGETS[0]).groupby("precision").sum()
    fine = (least <= TARGETS[1]).unstack("precision")  # noqa: PD010
    lost = (~fine["single"])[fine["double"]].groupby("method").agg(["sum", "count"])
    require(coarse["single"] == coarse["double"], "no step is lost within 1e-4 in single precision")
    pair = table.pivot_table(index=["method", "case", "limit"], columns="precision", values="seconds")
    slower = (pair["single"] / pair["double"])[lambda ratio: ratio.index.get_level_values("limit") == table["limit"].max()]
    numbers = {
        "cases": table["case"].nunique(),
        "longest": table["limit"].max(),
        "rounded": [f"{rounding.median():.0e}", f"{rounding.max():.0e}"],
        "at_coarse": _solved(least, TARGETS[0]),
        "at_fine": _solved(least, TARGETS[1]),
        "lost": listing(["{} of {} ({})".format(*lost.loc[name], name) for name in METHODS]),
        "floors": listing(
            [f"{least[name, 'single'].median():.0e} to {least[name, 'single'].quantile(0.9):.0e} ({name})" for name in METHODS]
        ),
        "ratios": [f"{ratio:.2f}" for ratio in slower.quantile([0.1, 0.5, 0.9])],
    }
    return Summary(numbers, {"time": [Panel(name, partial(_curves, table=table[table["method"] == name])) for name in METHODS]})


def _solved(least: pd.Series, target: float) -> str:
    """Return the number of steps that each method brings within the target, in single and in double precision."""
    count = (least <= target).groupby(["method", "precision"]).sum()
    return listing([f"{count[name, 'single']} and {count[name, 'double']} ({name})" for name in METHODS])


def _curves(ax: Axes, table: pd.DataFrame) -> None:
    for k, precision in enumerate(PRECISIONS):
        group = table[table["precision"] == precision].groupby("limit")
        for level, ls in ((0.5, "-"), (0.9, ":")):
            low, time = group["residual"].quantile(level).clip(lower=1e-16), 1e3 * group["seconds"].median()
            curve(ax, k, time, low, f"{precision}, {'median' if level == 0.5 else '9 of 10 below'}", ls=ls)
    finish(ax, "ms", "residual", "xy")


STUDY = Study((rounded, reached), summary)
