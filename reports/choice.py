"""Which solver to choose: for each kind of problem the solver with the least mean time to a target, its lead and win rate.

The mean is the shifted geometric mean of reports.accuracy, with problems not solved charged the time limit. Only solvers
that ran on every problem of the kind are ranked, so that all are compared on the same problems. The lead is the mean of the
second solver over that of the first. The win rate is the share of DRAWS bootstrap samples of the problems in which the same
solver is first. Problems of one scene are similar, so the win rate applies to problems like these.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd

from frictionbench.reports.accuracy import SHIFT
from frictionbench.reports.run import Run
from frictionbench.results.conventions import COLD, WARM

SMALL, MEDIUM = 10, 100  # contacts: the largest problems of these two kinds, a decade each
ILL = 1e8  # condition of W on its range, at which a factorisation loses half of the digits of double precision
DRAWS = 1000  # bootstrap samples: the standard error of a win rate is below 2 %
FEW = 5  # problems; of so few the bootstrap gives no meaningful win rate


class Choice(NamedTuple):
    """The fastest solver on a kind of problem; `next` and `lead` are None if no other solver ran on all of the problems.

    mean: s. reached: the number of problems solved to the target. win_rate: None for FEW problems or less.
    """

    label: str
    mean: float
    reached: int
    problems: int
    next: str | None
    lead: float | None
    win_rate: float | None


def choices(run: Run, among: set[str] | None = None) -> list[tuple[str, dict[float, Choice]]]:
    """For each kind of problem in the run, the choice at each target that some solver reaches.

    among: the labels to choose from; None for all. A kind that consists of all problems is listed as such only.
    """
    problems = run.ranked.drop_duplicates("problem_id").set_index("problem_id")
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
    cold, warm = (set(run.rows.loc[run.rows["start"].isin(starts), "label"]) for starts in (["", COLD], [WARM]))
    asked = [(kind, set(problems.index[chosen]), cold) for kind, chosen in kinds.items()]
    asked.append(("warm starts", set(problems.index), warm))
    everything = set(problems.index)
    found = []
    for kind, chosen, labels in asked:
        if chosen and labels and (chosen != everything or kind in ("all problems", "warm starts")):
            best = {
                target: choose(times, chosen, labels if among is None else labels & among)
                for target, times in run.times.items()
            }
            found.append((kind, {target: choice for target, choice in best.items() if choice}))
    return found


def choose(times: pd.DataFrame, problems: set[int], labels: set[str]) -> Choice | None:
    """The choice for these problems among these labels; None if none of them reaches the target on any problem.

    times: a row per problem and label with `charged` (s) and `reached`, see reports.accuracy.times_to.
    """
    own = times[times["problem_id"].isin(problems) & times["label"].isin(labels)]
    if not own["reached"].any():
        return None
    table = own.pivot_table(index="problem_id", columns="label", values="charged").reindex(sorted(problems)).dropna(axis=1)
    if table.empty:
        return None
    logs = np.log(table.to_numpy() + SHIFT)
    order = np.argsort(logs.mean(axis=0), kind="stable")
    means = np.exp(logs.mean(axis=0)) - SHIFT
    first = table.columns[order[0]]
    weights = np.random.default_rng(0).multinomial(len(logs), np.full(len(logs), 1 / len(logs)), size=DRAWS)
    win_rate = float(np.mean(np.argmin(weights @ logs, axis=1) == order[0])) if len(logs) > FEW else None
    reached = int(own.loc[own["label"] == first, "reached"].sum())
    following = str(table.columns[order[1]]) if len(order) > 1 else None
    lead = float(means[order[1]] / means[order[0]]) if following else None
    return Choice(str(first), float(means[order[0]]), reached, len(table), following, lead, win_rate)
