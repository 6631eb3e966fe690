"""Which solver: of each kind of problem the entry with the least mean time to a target, its lead, reliability and certainty.

The mean is the shifted geometric mean of reports.accuracy, misses charged at the time limit. Only entries that ran on every
problem of the kind are ranked, so that all are judged by the same problems. The lead is the next entry's mean over the
winner's. How sure that is comes from DRAWS bootstrap samples of the problems: the share in which the same entry wins. Problems
of one scene are alike, so the certainty is that for problems like these, and no more.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd

from frictionbench.reports.accuracy import SHIFT
from frictionbench.reports.run import Run
from frictionbench.results.conventions import COLD, WARM

SMALL, MEDIUM = 10, 100  # contacts
ILL = 1e8  # condition of W on its range
DRAWS = 1000
FEW = 5  # problems: of fewer a sample says nothing


class Choice(NamedTuple):
    """The winner of a kind of problem; lead and next are None where nobody else ran on all of them."""

    entry: str
    mean: float  # s
    reached: int
    problems: int
    next: str | None
    lead: float | None
    sure: float | None  # share of the bootstrap samples; None of FEW problems or less


def choices(run: Run, among: set[str] | None = None) -> list[tuple[str, dict[float, Choice]]]:
    """Of each kind that has problems of its own, the winner at each target that somebody reaches.

    among: entries that may win; all where None.
    """
    problems = run.contested.drop_duplicates("problem_id").set_index("problem_id")
    contacts = problems["contacts"]
    kinds = {
        "all problems": contacts.notna(),
        f"small: up to {SMALL} contacts": contacts <= SMALL,
        f"medium: {SMALL + 1} to {MEDIUM} contacts": (contacts > SMALL) & (contacts <= MEDIUM),
        f"large: more than {MEDIUM} contacts": contacts > MEDIUM,
        f"ill-conditioned: condition above {ILL:.0e}".replace("e+0", "e"): problems["condition"] > ILL,
        "planar": problems["dimension"] == 2,
        "spatial": problems["dimension"] == 3,
    }
    cold, warm = (set(run.rows.loc[run.rows["start"].isin(starts), "entry"]) for starts in (["", COLD], [WARM]))
    asked = [(kind, set(problems.index[chosen]), cold) for kind, chosen in kinds.items()]
    asked.append(("warm starts", set(problems.index), warm))
    everything = set(problems.index)
    found = []
    for kind, chosen, entries in asked:
        if chosen and entries and (chosen != everything or kind in ("all problems", "warm starts")):
            best = {
                target: choose(times, chosen, entries if among is None else entries & among)
                for target, times in run.times.items()
            }
            found.append((kind, {target: choice for target, choice in best.items() if choice}))
    return found


def choose(times: pd.DataFrame, problems: set[int], entries: set[str]) -> Choice | None:
    """The winner of these problems among these entries; None where none of them reaches the target anywhere.

    times: a row per problem and entry with `charged` (s) and `reached`, see reports.accuracy.times_to.
    """
    own = times[times["problem_id"].isin(problems) & times["entry"].isin(entries)]
    if not own["reached"].any():
        return None
    table = own.pivot_table(index="problem_id", columns="entry", values="charged").reindex(sorted(problems)).dropna(axis=1)
    if table.empty:
        return None
    logs = np.log(table.to_numpy() + SHIFT)
    order = np.argsort(logs.mean(axis=0), kind="stable")
    means = np.exp(logs.mean(axis=0)) - SHIFT
    first = table.columns[order[0]]
    weights = np.random.default_rng(0).multinomial(len(logs), np.full(len(logs), 1 / len(logs)), size=DRAWS)
    sure = float(np.mean(np.argmin(weights @ logs, axis=1) == order[0])) if len(logs) > FEW else None
    reached = int(own.loc[own["entry"] == first, "reached"].sum())
    following = str(table.columns[order[1]]) if len(order) > 1 else None
    lead = float(means[order[1]] / means[order[0]]) if following else None
    return Choice(str(first), float(means[order[0]]), reached, len(table), following, lead, sure)
