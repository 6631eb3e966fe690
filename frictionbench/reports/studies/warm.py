"""The study of warm starts."""

import json
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.problems.verdicts import ACCEPTED
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import finish
from frictionbench.reports.studies.numbers import listing
from frictionbench.results.conventions import COLD, SHUFFLED, WARM
from frictionbench.results.studies import StudyTables

STARTS = (COLD, WARM, SHUFFLED)
COUNTS = {  # of each method, what its work is measured by
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


def account(found: StudyTables) -> Account:
    rows = found["solves"]
    rows = rows.assign(solved=rows["verdict"].isin(list(ACCEPTED)))
    solved = rows.set_index([*KEYS, "start"])["solved"].unstack().dropna()  # noqa: PD010  # problems with all three starts
    answers = solved.groupby("variant").sum()
    problems = solved.groupby("variant").size()
    found.require(problems.min() == problems.max(), "all methods have the same problems")
    rows = rows.assign(count=[_count(*pair) for pair in zip(rows["variant"], rows["work"], strict=True)])
    counts = rows.set_index([*KEYS, "start"])["count"].unstack()  # noqa: PD010
    counts = counts.reindex(solved.index[solved.eq(True).all(axis=1)]).astype(float)
    motions = counts.groupby(["variant", "scene"]).sum()
    ratios = {name: {start: _ratio(own, start) for start in (WARM, SHUFFLED)} for name, own in motions.groupby(level="variant")}
    names = sorted(ratios, key=lambda name: ratios[name][WARM][0])
    gained = [name for name in names if ratios[name][WARM][2] < 1]
    nearer = [name for name in names if ratios[name][WARM][0] < ratios[name][SHUFFLED][0]]
    free = (counts[WARM] == 0).groupby("variant").mean()
    at_once = [f"{name} in {100 * free[name]:.0f} %" for name in names if free[name] > 0]
    lost = [name for name in names if answers.loc[name, WARM] < answers.loc[name, COLD]]
    middle = (motions[WARM] / motions[COLD]).groupby("variant").median()
    low, high = ratios[names[0]][WARM][0], ratios[names[-1]][WARM][0]
    told = [
        f"{name} ({COUNTS[name]}) {_words(ratios[name][WARM])}, {middle[name]:.2f} in the median motion, "
        f"from another step {ratios[name][SHUFFLED][0]:.2f}"
        for name in names
    ]
    return Account(
        answer=f"From the step before, methods take {low:.2f} ({names[0]}) to {high:.2f} ({names[-1]}) of their work from zero "
        f"in these motions; for {len(gained)} of {len(names)} the 95 % interval is below 1.",
        result=f"Of {problems.iloc[0]} problems with all three starts, the work from the step before over that from zero, in "
        f"the sum with its 95 % interval: {'; '.join(told)}. The step before is a better start than another step for "
        f"{len(nearer)} of {len(names)} methods, but another step of the same motion is already better than zero for "
        f"{sum(ratios[name][SHUFFLED][0] < 1 for name in names)}. Some need no work at all, because the start solves the "
        f"problem to the tolerance: {listing(at_once)} of "
        "the problems. "
        + (
            f"From the step before fewer problems are solved by {listing(lost)}."
            if lost
            else "No method solves fewer problems from the step before than from zero."
        ),
        limits="Counts of one method are not those of another: the ratios compare starts, not methods, and say nothing of the "
        "constant cost of a call. Sums weigh hard problems most; the figure shows each motion for itself. nsgs, nncg and "
        "admm_coulomb look at the residual every few sweeps or iterations, so their counts are rounded up. All motions are "
        "planar, of at most some twenty contacts. The start carries impulses, not active sets or factorisations, which a "
        "method made for sequences could keep.",
        figures=(
            Figure(
                "ratios",
                "Work from a start over work from zero, a point for each motion; the line is the ratio of the sums.",
                (
                    Panel("from the step before", partial(_draw, motions=motions, start=WARM, names=names, ratios=ratios)),
                    Panel("from another step", partial(_draw, motions=motions, start=SHUFFLED, names=names, ratios=ratios)),
                ),
            ),
        ),
    )


def _count(variant: str, work: object) -> float:
    """The method's own count; not a number where the cell has none, as after a time-out."""
    return float(json.loads(work).get(COUNTS[variant], np.nan)) if isinstance(work, str) else np.nan


def _ratio(own: pd.DataFrame, start: str, draws: int = 2000) -> tuple[float, float, float]:
    """The ratio of the sums, with the interval of 95 % by resampling the motions."""
    pick = np.random.default_rng(1).integers(len(own), size=(draws, len(own)))
    above, below = (own[column].to_numpy(float) for column in (start, COLD))
    low, high = np.quantile(above[pick].sum(axis=1) / below[pick].sum(axis=1), (0.025, 0.975))
    return float(above.sum() / below.sum()), float(low), float(high)


def _words(ratio: tuple[float, float, float]) -> str:
    return f"{ratio[0]:.2f} ({ratio[1]:.2f} to {ratio[2]:.2f})"


def _draw(
    ax: Axes,
    motions: pd.DataFrame,
    start: str,
    names: list[str],
    ratios: dict[str, dict[str, tuple[float, float, float]]],
) -> None:
    ax.axvline(1, color=INK, lw=0.6, ls=":")
    for k, name in enumerate(names):
        own = motions.loc[name]
        ax.plot(own[start] / own[COLD], np.full(len(own), k), "o", ms=3, alpha=0.6, color="#0077bb")
        ax.plot([ratios[name][start][0]] * 2, [k - 0.3, k + 0.3], color=INK, lw=1.2)
    ax.set_yticks(range(len(names)), names)
    finish(ax, "work over that from zero", "")
