"""Time to equal achieved accuracy, the headline speed.

For a problem and an entry it is the least median time, form, setup and solve together, over the entry's ladder of tolerances,
at which the *verified* residual is within the target; what the solver claimed plays no part. A miss is charged at the time
limit, not dropped. A class of problems is summed up by the shifted geometric mean (H. Mittelmann's benchmarks)

    exp(mean(log(t + s))) - s,     s = 1e-5 s,

where s is about what one call costs, so that differences below it do not rule the mean. An entry that was skipped on all of
a class has no figure there; one that enters a class and is skipped on some of it is charged for these. Over all problems
every entry is judged by the same ones: what it was skipped on is a miss, too.

Dolan and Moré's performance profile (2002) is the share of problems an entry brings within the target in at most tau times
the time of the fastest.
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from results.schema import SKIPPED

TARGETS = (1e-4, 1e-6, 1e-8)
Array = NDArray[np.float64]
SHIFT = 1e-5  # s
ALL = "all problems"


def shifted_geometric_mean(times: pd.Series) -> float:
    """The shifted geometric mean of times in s; nan of none."""
    return float(np.exp(np.log(times + SHIFT).mean()) - SHIFT) if len(times) else np.nan


def times_to(rows: pd.DataFrame, target: float) -> pd.DataFrame:
    """A row per problem and entry: class, reached, charged (s), and form_time, setup_time and solve_time where reached.

    rows: annotated rows of the solves table, trivial problems left out.
    """
    pair = ["problem_id", "entry"]
    within = rows[rows["answered"] & (rows["residual"] <= target)]
    best = within.sort_values("time", kind="stable").drop_duplicates(pair).set_index(pair)
    ran = rows.assign(ran=rows["verdict"] != SKIPPED)
    ran = ran[ran.groupby(["problem_class", "entry"])["ran"].transform("any")]
    known = {name: (name, "first") for name in ("problem_class", "start", "host")}
    times = ran.groupby(pair, sort=False).agg(**known, limit=("time_limit", "max"))
    times = times.join(best[["form_time", "setup_time", "solve_time", "time"]])
    times["reached"] = times["time"].notna()
    times["charged"] = times["time"].fillna(times["limit"])
    return times.reset_index()


def summary(times: pd.DataFrame) -> pd.DataFrame:
    """A row per class and entry, and per entry over all classes: problems, reached, share, mean (s), the medians of form,
    setup and solve (s) over the problems it reached, and written: form's share of all three."""
    both = pd.concat([_on_all(times), times], ignore_index=True)
    groups = both.groupby(["problem_class", "entry"], sort=False)
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


def _on_all(times: pd.DataFrame) -> pd.DataFrame:
    """The times with a row for every entry on every problem that has its start and was met by its host, the class ALL."""
    parts = [times]
    for _, own in times.groupby(["start", "host"], sort=False):
        limit = own.groupby("problem_id", sort=False)["limit"].max()
        pairs = pd.MultiIndex.from_product([limit.index, own["entry"].unique()], names=["problem_id", "entry"])
        lacking = pairs.difference(pd.MultiIndex.from_frame(own[["problem_id", "entry"]])).to_frame(index=False)
        parts.append(lacking.assign(reached=False, charged=lacking["problem_id"].map(limit)))
    return pd.concat([part for part in parts if len(part)] or parts, ignore_index=True).assign(problem_class=ALL)


def profile(times: pd.DataFrame) -> dict[str, tuple[Array, Array]]:
    """Of each entry the ratios tau, sorted, of the problems it reached, and the share of all problems within each."""
    reached = times[times["reached"]]
    fastest = reached.groupby("problem_id")["charged"].min()
    count = times["problem_id"].nunique()
    curves = {}
    for entry in times["entry"].unique():
        own = reached[reached["entry"] == entry]
        ratio = np.sort(own["charged"].to_numpy() / fastest.loc[own["problem_id"]].to_numpy())
        curves[entry] = (ratio, np.arange(1, len(ratio) + 1) / count)
    return curves
