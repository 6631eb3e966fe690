"""Time to equal achieved accuracy, the measure of speed by which reports rank solvers.

For a problem and a solver (a label, see reports.run) it is the least median time over the solver's tolerances at which the
*verified* residual is within the target. RankBy defines which times are compared. A problem not solved is charged the time
limit. A class of problems is summarised by the shifted geometric mean (H. Mittelmann's benchmarks) with weights w

    exp(sum w log(t + s)) - s,     s = 1e-5 s,

where s is about the cost of one call (docs/reading.md). The problems of one scene, one decade of contacts and one dimension
form a stratum: with S strata, a problem in a stratum of n problems has the weight w = 1 / (S n). n_eff = 1 / sum w^2 (Kish
1965) is the number of problems of equal weight whose mean has the same variance. A solver skipped on a whole class has no mean
there; one skipped on some of its problems is charged for these, and over all problems in the plane or in space for all.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.results.cells import repeats
from frictionbench.results.conventions import RankBy, law

TARGETS = (1e-4, 1e-6, 1e-8)  # from the accuracy of real-time simulation to that of reference solutions
LEVELS = {"p50": 0.5, "p99": 0.99, "worst": 1.0}
LEAST_FOR_P99 = 100  # problems: the least number for which the 99th percentile is not the maximum
OVERALL = {2: "in the plane", 3: "in space"}  # the class of all problems of a dimension
Array = NDArray[np.float64]
SHIFT = 1e-5  # s, about the cost of calling a solver


class Profile(NamedTuple):
    """The costs of one label on all problems, sorted and infinite if not solved, and the weight of each problem."""

    cost: Array
    weight: Array

    def share(self, at: Array) -> Array:
        """The weighted share of the problems whose cost is at most each value of `at`."""
        return np.r_[0.0, np.cumsum(self.weight)][np.searchsorted(self.cost, at, side="right")]


def targets(rows: pd.DataFrame) -> tuple[float, ...]:
    """Return the targets within the range of a run's tolerances or, if there is none, the tightest one that it reaches.

    rows: of the solves table.
    """
    reached = [target for target in TARGETS if target >= 0.999 * rows["tol"].min()] or list(TARGETS[:1])
    return tuple(target for target in reached if target <= 1.001 * rows["tol"].max()) or (reached[-1],)


def times_to(rows: pd.DataFrame, target: float, rank_by: RankBy = RankBy.BODIES) -> pd.DataFrame:
    """Return a row per problem and label: class, stratum, dimension, reached, charged (s), and if reached form_time,
    setup_time, solve_time, time (s), work and repeats (s). unjudgeable: not reached, but some answer is within the target or
    within its own rounding error, so that reaching the target cannot be decided. skipped: at every tolerance.

    rows: annotated rows of the solves table for ranked problems.
    """
    pair = ["problem_id", "label"]
    asked = rows[measured(rows)].groupby("label")["tol"].min()
    rows = rows[~(rows["label"].map(asked) > 1.001 * target)]
    floor = rows["residual_floor"].fillna(0.0)
    coarse = (rows["verdict"] == Verdict.UNJUDGEABLE) & (floor <= rows["tol"]) & (target >= rows["tol"])
    known = rows["answered"] & ~coarse & (floor <= target)
    within = rows[known & (rows["residual"] <= target)]
    within = within.assign(time=rank_by.time(within))
    best = within.sort_values("time", kind="stable").drop_duplicates(pair).set_index(pair)
    best["repeats"] = [repeats(*times) for times in zip(*(best[f"{column}s"] for column in rank_by.columns), strict=True)]
    open_cells = rows[rows["answered"] & ~known & (rows["residual"] <= np.maximum(target, floor))]
    ran = rows.assign(skipped=~measured(rows))
    ran = ran[~ran.groupby(["problem_class", "label"])["skipped"].transform("all")]
    names = ("problem_class", "stratum", "dimension", "scene", "cluster", "model", "start", "host")
    facts = {name: (name, "first") for name in names} | {"limit": ("time_limit", "max"), "skipped": ("skipped", "all")}
    times = ran.groupby(pair, sort=False).agg(**facts)
    times = times.join(best[[*RankBy.BODIES.columns, "time", "work", "repeats"]])
    times["reached"] = times["time"].notna()
    times["unjudgeable"] = ~times["reached"] & times.index.isin(pd.MultiIndex.from_frame(open_cells[pair]))
    times["charged"] = times["time"].fillna(times["limit"])
    return times.reset_index()


def summary(times: pd.DataFrame) -> pd.DataFrame:
    """Return a row per class and label, including the classes of OVERALL: problems; reached, unjudgeable and skipped, numbers
    of them as in `times_to`; solved, the first two as text; share and mean (s), both weighted; the medians of form, setup and
    solve (s) over the problems reached; written, the share of form; and law, see `laws`."""
    both = pd.concat([*overall(times).values(), times], ignore_index=True)
    both["weight"] = weights(both, ["problem_class", "label"])
    groups = both.groupby(["problem_class", "label"], sort=False)
    table = groups.agg(
        problems=("reached", "size"),
        reached=("reached", "sum"),
        unjudgeable=("unjudgeable", "sum"),
        skipped=("skipped", "sum"),
        form=("form_time", "median"),
        setup=("setup_time", "median"),
        solve=("solve_time", "median"),
        model=("model", "first"),
        dimension=("dimension", "first"),
    )
    table["share"] = (both["weight"] * both["reached"]).groupby([both["problem_class"], both["label"]], sort=False).sum()
    table["written"] = share_of_form(both, ["problem_class", "label"])
    logs = (both["weight"] * np.log(both["charged"] + SHIFT)).groupby([both["problem_class"], both["label"]], sort=False).sum()
    table["law"], has_mean = laws(table, table["problems"])
    table["mean"] = (np.exp(logs) - SHIFT).where(has_mean)
    table["solved"] = [*map(solved_words, table["reached"], table["unjudgeable"])]
    return table.drop(columns=["model", "dimension"]).reset_index()


def laws(table: pd.DataFrame, problems: "int | pd.Series[int]") -> tuple["pd.Series[str]", "pd.Series[bool]"]:
    """Return for each row the law that a solver solves instead of Coulomb's law, and whether it has a mean: a solver of another
    law has one only if it solves all problems. table: with columns model, dimension and reached. problems: their number."""
    other = table["model"].combine(table["dimension"], law)
    return other, (other == "") | (table["reached"] == problems)


def solved_words(reached: int, unjudgeable: int) -> str:
    """Return the numbers of solved and of unjudgeable problems as text: 40 + 80 unjudgeable."""
    return f"{reached:.0f}" + (f" + {unjudgeable:.0f} unjudgeable" if unjudgeable else "")


def share_of_form(times: pd.DataFrame, by: list[str]) -> "pd.Series[float]":
    """Return by groups the weighted mean, over the problems reached, of the share of form in form, setup and solve."""
    reached = times[times["reached"]]
    reached = reached.assign(weight=weights(reached, by))
    parts = reached[RankBy.BODIES.columns].fillna(0.0)
    share = reached["weight"] * parts["form_time"] / parts.sum(axis=1)
    return share.groupby([reached[name] for name in by], sort=False).sum()


def overall(times: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the times by the classes OVERALL, with a row for every label on every problem with its start and host, so that
    means, shares and profiles over all problems have the same denominator."""
    return {
        name: _completed(times[times["dimension"] == d], name) for d, name in OVERALL.items() if (times["dimension"] == d).any()
    }


def _completed(times: pd.DataFrame, name: str) -> pd.DataFrame:
    parts = [times]
    for _, group in times.groupby(["start", "host"], sort=False):
        first = dict.fromkeys(("stratum", "scene", "dimension"), "first")
        facts = group.groupby("problem_id", sort=False).agg({"limit": "max"} | first)
        models = group.groupby("label")["model"].first()
        pairs = pd.MultiIndex.from_product([facts.index, group["label"].unique()], names=["problem_id", "label"])
        lacking = pairs.difference(pd.MultiIndex.from_frame(group[["problem_id", "label"]])).to_frame(index=False)
        lacking = lacking.join(facts, on="problem_id").assign(model=lacking["label"].map(models))
        parts.append(lacking.assign(reached=False, unjudgeable=False, skipped=True, charged=lacking["limit"]))
    return pd.concat([part for part in parts if len(part)] or parts, ignore_index=True).assign(problem_class=name)


def profiles(times: pd.DataFrame, cost: str = "charged", *, relative: bool = True) -> dict[str, Profile]:
    """Return the profile of each label. times: one of `overall`. relative: whether costs are divided by the problem's least."""
    spent = times[cost].where(times["reached"], np.inf)
    spent = (spent / spent.groupby(times["problem_id"]).transform("min")).fillna(np.inf) if relative else spent
    table = pd.DataFrame({"label": times["label"], "cost": spent, "weight": weights(times, ["label"])})
    parts = table.sort_values("cost", kind="stable").groupby("label", sort=False)
    return {str(label): Profile(of_label["cost"].to_numpy(), of_label["weight"].to_numpy()) for label, of_label in parts}


def percentiles(times: pd.DataFrame, budget: float | None = None, *, weighted: bool = True) -> pd.DataFrame:
    """Return a row per label: the times within which half and 99 % of the problems are solved (p50, p99) and the longest
    (worst), s, infinite if not solved; p99 is NaN below LEAST_FOR_P99 problems, where it would be the longest. within: the
    share solved within the budget (s), NaN without one.

    times: one of `overall`, or the steps of one motion. weighted: whether by the weights above or with equal weights.
    """
    cost = times["charged"].where(times["reached"], np.inf).to_numpy()
    weight = weights(times, ["label"]).to_numpy() if weighted else np.ones(len(times))
    rows = {}
    for label, at in times.groupby("label", sort=False).indices.items():
        costs, share = cost[at], weight[at] / weight[at].sum()
        levels = {name: quantile(costs, share, level) for name, level in LEVELS.items()}
        levels["p99"] = levels["p99"] if len(costs) >= LEAST_FOR_P99 else np.nan
        rows[label] = levels | {"within": np.nan if budget is None else float(share[costs <= budget].sum())}
    return pd.DataFrame.from_dict(rows, orient="index", columns=[*LEVELS, "within"]).rename_axis("label")


def in_order(table: pd.DataFrame) -> pd.DataFrame:
    """Sort a table of `percentiles` by p99, or by the longest time where there is no p99."""
    return table.sort_values(["p99", "worst", "p50"], kind="stable")


def shown_levels(table: pd.DataFrame) -> list[str]:
    """Return the names of the percentiles that a table shows: p99 only if some row has it."""
    return [name for name in LEVELS if name != "p99" or table["p99"].notna().any()]


def strata(rows: pd.DataFrame) -> "pd.Series[str]":
    """Return the name of each row's stratum, with the decade of its contacts: 1e1 for up to 10, 1e2 for 11 to 100, and so on.

    rows: with columns scene, contacts and dimension."""
    decade = np.ceil(np.log10(rows["contacts"].fillna(0).clip(lower=1))).clip(lower=1).astype(int)
    return rows["scene"] + " 1e" + decade.astype(str) + " d" + rows["dimension"].fillna(0).astype(int).astype(str)


def weights(rows: pd.DataFrame, by: Sequence[str] = ()) -> "pd.Series[float]":
    """Return the weight of each row, which is a problem's, within its group by the columns `by`. The weights of each group have
    the sum 1. rows: with the column stratum."""
    keys = [rows[name] for name in by] or [pd.Series(0, index=rows.index)]
    in_stratum = rows.groupby([*keys, rows["stratum"]], sort=False)["stratum"].transform("size")
    return 1 / (in_stratum * rows["stratum"].groupby(keys, sort=False).transform("nunique"))


def effective(weight: Array) -> float:
    """Return n_eff as defined above, 0 without problems."""
    return float(weight.sum() ** 2 / (weight**2).sum()) if len(weight) else 0.0


def shifted_geometric_mean(times: Array | pd.Series, weight: Array | pd.Series | None = None) -> float:
    """Return exp(sum w log(t + s)) - s of times t in seconds, s = 1e-5 s; NaN without times. weight: equal by default."""
    return float(np.exp(np.average(np.log(np.asarray(times) + SHIFT), weights=weight)) - SHIFT) if len(times) else np.nan


def quantile(values: Array, weight: Array, level: float) -> float:
    """Return the least value that the share `level` of the weight does not exceed (nearest rank); NaN without values."""
    if not len(values):
        return np.nan
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weight[order]) / weight.sum()
    at = int(np.searchsorted(share, level - 1e-12))
    return float(values[order][min(at, len(values) - 1)])
