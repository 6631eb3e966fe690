"""Time to equal achieved accuracy, the measure of speed by which reports rank solvers.

For a problem and a solver (a label, see reports.run) it is the least median time, form, setup and solve together, over all
tolerances of the solver, at which the *verified* residual is within the target; whether the solver claimed a solution has no
influence. A problem not solved is charged the time limit. A class of problems is summarised by the shifted geometric mean
(H. Mittelmann's benchmarks)

    exp(mean(log(t + s))) - s,     s = 1e-5 s,

where s is about the cost of one call, so that differences below it have little weight. A solver that was skipped on a whole
class has no mean there; one that was skipped on some of its problems is charged for these. Over all problems the solvers are
compared on the same problems, so that every problem skipped counts as not solved.

The performance profile of Dolan and Moré (2002) is the share of these problems solved to the target within tau times the
time of the fastest solver. A solver that was skipped on whole classes is also compared with the others on the
problems that it ran on. `by_charge` shows how the ranking depends on the charge for a problem not solved.
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from frictionbench.results.verdicts import measured

TARGETS = (1e-4, 1e-6, 1e-8)  # two decades apart: from the accuracy of real-time simulation to that of reference solutions
Array = NDArray[np.float64]
SHIFT = 1e-5  # s, about the cost of calling a solver
CHARGES = (1, 3, 10)  # time limits charged for a problem not solved, up to a decade
DRAWS = 500  # bootstrap samples: enough for percentiles 2.5 and 97.5, which rest on a dozen samples each
ALL = "all problems"


def shifted_geometric_mean(times: pd.Series) -> float:
    """The shifted geometric mean of times in s; nan of none."""
    return float(np.exp(np.log(times + SHIFT).mean()) - SHIFT) if len(times) else np.nan


def targets(rows: pd.DataFrame) -> tuple[float, ...]:
    """The targets that are not below the tightest tolerance of a run; the coarsest if all of them are.

    rows: of the solves table.
    """
    return tuple(target for target in TARGETS if target >= 0.999 * rows["tol"].min()) or TARGETS[:1]


def times_to(rows: pd.DataFrame, target: float) -> pd.DataFrame:
    """A row per problem and label: class, reached, charged (s), and form_time, setup_time, solve_time and work where reached.

    rows: annotated rows of the solves table, trivial problems left out.
    """
    pair = ["problem_id", "label"]
    within = rows[rows["answered"] & (rows["residual"] <= target)]
    best = within.sort_values("time", kind="stable").drop_duplicates(pair).set_index(pair)
    ran = rows.assign(ran=measured(rows))
    ran = ran[ran.groupby(["problem_class", "label"])["ran"].transform("any")]
    known = {name: (name, "first") for name in ("problem_class", "start", "host")}
    times = ran.groupby(pair, sort=False).agg(**known, limit=("time_limit", "max"))
    times = times.join(best[["form_time", "setup_time", "solve_time", "time", "work"]])
    times["reached"] = times["time"].notna()
    times["charged"] = times["time"].fillna(times["limit"])
    return times.reset_index()


def summary(times: pd.DataFrame) -> pd.DataFrame:
    """A row per class and label, and per label over all classes: problems, reached (how many within the target), share, mean
    (s), the medians of form, setup and solve (s) over the problems reached, and written: the share of form in the time."""
    both = pd.concat([on_all(times), times], ignore_index=True)
    groups = both.groupby(["problem_class", "label"], sort=False)
    table = groups.agg(
        problems=("reached", "size"),
        reached=("reached", "sum"),
        share=("reached", "mean"),
        form=("form_time", "median"),
        setup=("setup_time", "median"),
        solve=("solve_time", "median"),
    )
    table["written"] = groups["form_time"].sum() / groups["time"].sum()
    table["mean"] = groups["charged"].agg(shifted_geometric_mean)
    return table.reset_index()


def on_all(times: pd.DataFrame) -> pd.DataFrame:
    """The times as class ALL, with a row for every label on every problem that has its start and host: means, shares and
    profiles over all problems have the same denominator."""
    parts = [times]
    for _, own in times.groupby(["start", "host"], sort=False):
        limit = own.groupby("problem_id", sort=False)["limit"].max()
        pairs = pd.MultiIndex.from_product([limit.index, own["label"].unique()], names=["problem_id", "label"])
        lacking = pairs.difference(pd.MultiIndex.from_frame(own[["problem_id", "label"]])).to_frame(index=False)
        charged = lacking["problem_id"].map(limit)
        parts.append(lacking.assign(reached=False, charged=charged, limit=charged))
    return pd.concat([part for part in parts if len(part)] or parts, ignore_index=True).assign(problem_class=ALL)


def ratios(times: pd.DataFrame, cost: str = "charged") -> dict[str, Array]:
    """For each label its cost over the least cost of any label on each problem of `on_all`, sorted; infinite if not solved."""
    both = on_all(times)
    least = both[both["reached"]].groupby("problem_id")[cost].min()
    ratio = (both[cost] / both["problem_id"].map(least)).where(both["reached"], np.inf)
    return {str(label): np.sort(own.to_numpy()) for label, own in ratio.groupby(both["label"], sort=False)}


def band(ratio: Array, at: Array) -> tuple[Array, Array]:
    """The pointwise 95 % bootstrap band of a performance profile, its lower and upper shares at each tau of `at`.

    ratio: sorted. In a bootstrap sample of the problems, the number within tau has a binomial distribution, which is sampled.
    """
    n = len(ratio)
    within = np.searchsorted(ratio, at, side="right") / max(n, 1)
    drawn = np.random.default_rng(0).binomial(n, within, size=(DRAWS, len(at))) / max(n, 1)
    low, high = np.percentile(drawn, [2.5, 97.5], axis=0)
    return low, high


def by_charge(times: pd.DataFrame) -> pd.DataFrame:
    """A row per label: for each of CHARGES its mean (s) over all problems and its rank; failed: problems not solved."""
    both = on_all(times)
    columns = {}
    for charge in CHARGES:
        charged = both["charged"].where(both["reached"], charge * both["limit"])
        columns[f"mean {charge}"] = charged.groupby(both["label"], sort=False).agg(shifted_geometric_mean)
        columns[f"rank {charge}"] = columns[f"mean {charge}"].rank(method="min")
    failed = (~both["reached"]).groupby(both["label"], sort=False).sum()
    return pd.DataFrame(columns).assign(failed=failed).sort_values("mean 1", kind="stable").reset_index()


def partial_rankings(times: pd.DataFrame) -> pd.DataFrame:
    """A row per label that was skipped on whole classes: the number of problems that it ran on (ran_on), of all; and on these
    its rank among the solvers that ran on all of them (others, itself included), its mean (s), and the best label with its own.
    """
    found = []
    count = on_all(times)["label"].value_counts()
    for label, own in times.groupby("label", sort=False):
        if len(own) < count[label]:
            same = times[times["problem_id"].isin(own["problem_id"])]
            groups = same.groupby("label")["charged"]
            means = groups.agg(shifted_geometric_mean)[groups.size() == len(own)].sort_values(kind="stable")
            rank = int((means < means[label]).sum()) + 1
            row = {"label": label, "ran_on": len(own), "of": int(count[label]), "rank": rank, "others": len(means)}
            reached = int(own["reached"].sum())
            found.append(row | {"reached": reached, "mean": means[label], "best": means.index[0], "best_mean": means.iloc[0]})
    return pd.DataFrame(found)
