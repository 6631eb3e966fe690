"""The weights of problems in means over problems, so that no scene decides a mean by its number of problems.

The problems of one scene, one decade of contacts and one dimension are a stratum. Each stratum has the same weight, which its
problems share: with S strata a problem of a stratum of n problems has the weight

    w = 1 / (S n),     sum w = 1.

Means, shares, profiles and percentiles over problems use these weights. n_eff = 1 / sum w^2 (Kish 1965) is the number of
problems of equal weight whose mean is as certain; it is the size of bootstrap samples, whose problems are drawn with the
probabilities w.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]
SHIFT = 1e-5  # s, about the cost of calling a solver


def decade(contacts: "pd.Series[float]") -> "pd.Series[int]":
    """The exponent of each number's decade: 1 for up to 10 contacts, 2 for 11 to 100, and so on."""
    return np.ceil(np.log10(contacts.fillna(0).clip(lower=1))).clip(lower=1).astype(int)


def strata(rows: pd.DataFrame) -> "pd.Series[str]":
    """The name of each row's stratum. rows: with scene, contacts and dimension."""
    size, dimension = decade(rows["contacts"]).astype(str), rows["dimension"].fillna(0).astype(int).astype(str)
    return rows["scene"] + " 1e" + size + " d" + dimension


def weights(rows: pd.DataFrame, by: Sequence[str] = ()) -> "pd.Series[float]":
    """The weight of each row, a problem's, within each group of rows with equal values of the columns `by`; each group has the
    sum 1. rows: with the column stratum."""
    keys = [rows[name] for name in by] or [pd.Series(0, index=rows.index)]
    in_stratum = rows.groupby([*keys, rows["stratum"]], sort=False)["stratum"].transform("size")
    return 1 / (in_stratum * rows["stratum"].groupby(keys, sort=False).transform("nunique"))


def effective(weight: Array) -> float:
    """The number of problems of equal weight whose mean is as certain; 0 for none."""
    return float(weight.sum() ** 2 / (weight**2).sum()) if len(weight) else 0.0


def shifted_geometric_mean(times: Array | pd.Series, weight: Array | pd.Series | None = None) -> float:
    """exp(sum w log(t + s)) - s of times in s, s = 1e-5 s; nan of none. weight: equal by default."""
    return float(np.exp(np.average(np.log(np.asarray(times) + SHIFT), weights=weight)) - SHIFT) if len(times) else np.nan


def quantile(values: Array, weight: Array, level: float) -> float:
    """The least value that the share `level` of the weight does not exceed (nearest rank); nan of none."""
    if not len(values):
        return np.nan
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weight[order]) / weight.sum()
    at = int(np.searchsorted(share, level - 1e-12))
    return float(values[order][min(at, len(values) - 1)])
