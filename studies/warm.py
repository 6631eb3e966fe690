"""The benefit of warm starts: recorded motions replayed from zero, from the previous step, and from another step."""

import json
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.problems import ACCEPTED
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.results.conventions import COLD, SHUFFLED, WARM
from studies.study import Study, Summary, Tables, finish, listing, require

STARTS = (COLD, WARM, SHUFFLED)
COUNTS = {  # the counter that measures each method's work
    "lemke": "pivots",
    "interior_point": "iterations",
    "nsgs": "sweeps",
    "nncg": "sweeps",
    "staggered": "products",
    "anitescu_hart": "products",
    "apgd_coulomb": "products",
    "admm_coulomb": "iterations",
}
KEYS = ["variant", "scene", "problem", "step", "phase"]
EXAMPLES = tuple(f"example_{number}" for number in range(1, 8))
SOLVERS = ("lemke", "interior_point", "nsgs", "staggered", "nncg", "anitescu_hart", "apgd_coulomb", "admm_coulomb")
PILES = (
    Source("stack", {"blocks": 5, "push": 0.5}, pick=8, steps=60, repeats=1),
    Source("pyramid", {"rows": 3, "push": 0.2}, pick=8, steps=60, repeats=1),
    Source("disc_pile", {"rows": 4}, pick=8, steps=60, repeats=1),
    Source("arch", {}, pick=8, steps=60, repeats=1),
)


def plan() -> Plan:
    """Return the plan: problems of the seven examples and of piles, each with three starts; times are not used or repeated."""
    return Plan(
        suite="study warm",
        sources=(*(Source(name, pick=8, steps=150, repeats=1) for name in EXAMPLES), *PILES),
        solvers=SOLVERS,
        tolerances=(1e-8,),
        starts=(COLD, WARM, SHUFFLED),
        time_limit=10.0,
    )


def summary(tables: Tables) -> Summary:
    rows = tables["solves"]
    rows = rows.assign(solved=rows["verdict"].isin(list(ACCEPTED)))
    solved = rows.set_index([*KEYS, "start"])["solved"].unstack().dropna()  # noqa: PD010  # problems with all three starts
    answers = solved.groupby("variant").sum()
    problems = solved.groupby("variant").size()
    require(problems.min() == problems.max(), "all methods have the same problems")
    rows = rows.assign(count=[_count(*pair) for pair in zip(rows["variant"], rows["work"], strict=True)])
    counts = rows.set_index([*KEYS, "start"])["count"].unstack()  # noqa: PD010
    counts = counts.reindex(solved.index[solved.eq(True).all(axis=1)]).astype(float)
    motions = counts.groupby(["variant", "scene"]).sum()
    methods = motions.index.unique("variant")
    ratios = {
        name: {start: _ratio(group, start, len(methods)) for start in (WARM, SHUFFLED)}
        for name, group in motions.groupby(level="variant")
    }
    names = sorted(ratios, key=lambda name: ratios[name][WARM][0])
    free = (counts[WARM] == 0).groupby("variant").mean()
    middle = (motions[WARM] / motions[COLD]).groupby("variant").agg(["median", "min", "max"]).sort_values("median")
    missing = 0.5 ** (motions.groupby("variant").size().min() - 1)  # that a median is beyond the least or the largest
    texts = [
        f"{name} ({COUNTS[name]}) {'{:.2f} ({:.2f} to {:.2f})'.format(*ratios[name][WARM])}, "
        f"{_spread(middle.loc[name])} in the median motion, from another step {ratios[name][SHUFFLED][0]:.2f}"
        for name in names
    ]
    numbers = {
        "middles": [f"{_spread(middle.loc[name])} for {name}" for name in middle.index[[0, -1]]],
        "sure": f"{100 * (1 - len(names) * missing):.3g}",
        "gained": sum(ratios[name][WARM][2] < 1 for name in names),
        "methods": len(names),
        "problems": problems.iloc[0],
        "ratios": "; ".join(texts),
        "nearer": sum(ratios[name][WARM][0] < ratios[name][SHUFFLED][0] for name in names),
        "shuffled_better": sum(ratios[name][SHUFFLED][0] < 1 for name in names),
        "at_once": listing([f"{name} in {100 * free[name]:.0f} %" for name in names if free[name] > 0]),
        "lost": listing([name for name in names if answers.loc[name, WARM] < answers.loc[name, COLD]]),
    }
    of_sums = {start: {name: ratios[name][start][0] for name in names} for start in (WARM, SHUFFLED)}
    panels = [
        Panel(f"from {step}", partial(_draw, motions=motions, start=start, ratios=of_sums[start]))
        for step, start in (("the step before", WARM), ("another step", SHUFFLED))
    ]
    return Summary(numbers, {"ratios": panels})


def _spread(of: pd.Series) -> str:
    return "{:.2f} ({:.2f} to {:.2f})".format(*of)


def _count(variant: str, work: object) -> float:
    """Return the method's own count; NaN if the cell has none, as after a timeout."""
    return float(json.loads(work).get(COUNTS[variant], np.nan)) if isinstance(work, str) else np.nan


def _ratio(group: pd.DataFrame, start: str, methods: int, draws: int = 2000) -> tuple[float, float, float]:
    """Return the ratio of the sums, with its 95 % interval for so many methods together, by resampling the motions."""
    pick = np.random.default_rng(1).integers(len(group), size=(draws, len(group)))
    above, below = (group[column].to_numpy(float) for column in (start, COLD))
    low, high = np.quantile(above[pick].sum(axis=1) / below[pick].sum(axis=1), (0.025 / methods, 1 - 0.025 / methods))
    return float(above.sum() / below.sum()), float(low), float(high)


def _draw(ax: Axes, motions: pd.DataFrame, start: str, ratios: dict[str, float]) -> None:
    ax.axvline(1, color=INK, lw=0.6, ls=":")
    for k, (name, ratio) in enumerate(ratios.items()):
        group = motions.loc[name]
        ax.plot(group[start] / group[COLD], np.full(len(group), k), "o", ms=3, alpha=0.6, color="#0077bb")
        ax.plot([ratio] * 2, [k - 0.3, k + 0.3], color=INK, lw=1.2)
    ax.set_yticks(range(len(ratios)), list(ratios))
    finish(ax, "work over that from zero", "")


STUDY = Study((), summary, plan)
