"""Time to equal achieved accuracy, the headline speed.

For a problem and an label it is the least median time, form, setup and solve together, over the label's ladder of tolerances,
at which the *verified* residual is within the target; what the solver claimed plays no part. A miss is charged at the time
limit, not dropped. A class of problems is summed up by the shifted geometric mean (H. Mittelmann's benchmarks)

    exp(mean(log(t + s))) - s,     s = 1e-5 s,

where s is about what one call costs, so that differences below it do not rule the mean. An label that was skipped on all of
a class has no figure there; one that enters a class and is skipped on some of it is charged for these. Over all problems
every label is judged by the same ones: what it was skipped on is a miss, too.

Dolan and Moré's performance profile (2002) is the share of the same problems that an label brings within the target in at
most tau times the time of the fastest. Whoever was skipped on whole classes is compared on those it entered, too, with the
others on the same. How much of a ranking is the charge for a miss shows where that is made larger.
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from frictionbench.results.verdicts import Verdict

TARGETS = (1e-4, 1e-6, 1e-8)
Array = NDArray[np.float64]
SHIFT = 1e-5  # s
CHARGES = (1, 3, 10)  # time limits that a miss may be charged
DRAWS = 500  # of a bootstrap
ALL = "all problems"


def shifted_geometric_mean(times: pd.Series) -> float:
    """The shifted geometric mean of times in s; nan of none."""
    return float(np.exp(np.log(times + SHIFT).mean()) - SHIFT) if len(times) else np.nan


def targets(rows: pd.DataFrame) -> tuple[float, ...]:
    """Those targets that a run asked for: nobody is told to miss what it was not asked. The coarsest where it asked for less.

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
    ran = rows.assign(ran=rows["verdict"] != Verdict.SKIPPED)
    ran = ran[ran.groupby(["problem_class", "label"])["ran"].transform("any")]
    known = {name: (name, "first") for name in ("problem_class", "start", "host")}
    times = ran.groupby(pair, sort=False).agg(**known, limit=("time_limit", "max"))
    times = times.join(best[["form_time", "setup_time", "solve_time", "time", "work"]])
    times["reached"] = times["time"].notna()
    times["charged"] = times["time"].fillna(times["limit"])
    return times.reset_index()


def summary(times: pd.DataFrame) -> pd.DataFrame:
    """A row per class and label, and per label over all classes: problems, reached, share, mean (s), the medians of form,
    setup and solve (s) over the problems it reached, and written: form's share of all three."""
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
    """The times with a row for every label on every problem that has its start and was met by its host, the class ALL: the
    one denominator of mean, share and profile."""
    parts = [times]
    for _, own in times.groupby(["start", "host"], sort=False):
        limit = own.groupby("problem_id", sort=False)["limit"].max()
        pairs = pd.MultiIndex.from_product([limit.index, own["label"].unique()], names=["problem_id", "label"])
        lacking = pairs.difference(pd.MultiIndex.from_frame(own[["problem_id", "label"]])).to_frame(index=False)
        charged = lacking["problem_id"].map(limit)
        parts.append(lacking.assign(reached=False, charged=charged, limit=charged))
    return pd.concat([part for part in parts if len(part)] or parts, ignore_index=True).assign(problem_class=ALL)


def ratios(times: pd.DataFrame, cost: str = "charged") -> dict[str, Array]:
    """Of each label its cost over the least of anybody's, of each problem of `on_all`; infinite where it missed."""
    both = on_all(times)
    least = both[both["reached"]].groupby("problem_id")[cost].min()
    ratio = (both[cost] / both["problem_id"].map(least)).where(both["reached"], np.inf)
    return {str(label): np.sort(own.to_numpy()) for label, own in ratio.groupby(both["label"], sort=False)}


def profile(times: pd.DataFrame, cost: str = "charged") -> dict[str, tuple[Array, Array]]:
    """Of each label the ratios tau, sorted, of the problems it reached, and the share of all its problems within each."""
    reached = {label: (ratio[np.isfinite(ratio)], len(ratio)) for label, ratio in ratios(times, cost).items()}
    return {label: (ratio, np.arange(1, len(ratio) + 1) / count) for label, (ratio, count) in reached.items()}


def band(ratio: Array, at: Array) -> tuple[Array, Array]:
    """The bootstrap band of a profile: between which shares 95 of 100 profiles of as many problems, drawn again with
    replacement, lie at each tau of `at`. A problem drawn again keeps its ratio, so that only the share within tau is drawn."""
    n = len(ratio)
    within = np.searchsorted(ratio, at, side="right") / max(n, 1)
    drawn = np.random.default_rng(0).binomial(n, within, size=(DRAWS, len(at))) / max(n, 1)
    low, high = np.percentile(drawn, [2.5, 97.5], axis=0)
    return low, high


def by_charge(times: pd.DataFrame) -> pd.DataFrame:
    """A row per label: of each of CHARGES, in time limits, its mean (s) over all problems with misses charged so, its rank."""
    both = on_all(times)
    columns = {}
    for charge in CHARGES:
        charged = both["charged"].where(both["reached"], charge * both["limit"])
        columns[f"mean {charge}"] = charged.groupby(both["label"], sort=False).agg(shifted_geometric_mean)
        columns[f"rank {charge}"] = columns[f"mean {charge}"].rank(method="min")
    missed = (~both["reached"]).groupby(both["label"], sort=False).sum()
    return pd.DataFrame(columns).assign(missed=missed).sort_values("mean 1", kind="stable").reset_index()


def entered_in_part(times: pd.DataFrame) -> pd.DataFrame:
    """A row per label that was skipped on whole classes: how many of all problems it entered, and on these alone its rank
    among the `others` that entered all of them, itself with them, its mean, and the best label with its mean (s)."""
    found = []
    count = on_all(times)["label"].value_counts()
    for label, own in times.groupby("label", sort=False):
        if len(own) < count[label]:
            same = times[times["problem_id"].isin(own["problem_id"])]
            groups = same.groupby("label")["charged"]
            means = groups.agg(shifted_geometric_mean)[groups.size() == len(own)].sort_values(kind="stable")
            rank = int((means < means[label]).sum()) + 1
            told = {"label": label, "entered": len(own), "of": int(count[label]), "rank": rank, "others": len(means)}
            reached = int(own["reached"].sum())
            found.append(told | {"reached": reached, "mean": means[label], "best": means.index[0], "best_mean": means.iloc[0]})
    return pd.DataFrame(found)
