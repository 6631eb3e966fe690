"""The report's tables of who solves what, from the annotated solves table and the drives table."""

from typing import NamedTuple

import pandas as pd

from reports.accuracy import ALL
from reports.cells import contested
from results.schema import CRASHED, RELAXED, SKIPPED, SOLVED, TIMEOUT, UNSOLVED, WRONG

OUTCOMES = (SOLVED, RELAXED, WRONG, UNSOLVED, TIMEOUT, CRASHED, SKIPPED)
NEARLY = 0.9  # as many problems as the best


def solvability(rows: pd.DataFrame) -> pd.DataFrame:
    """A row per entry: trivial (cells left out of all that follows), cells, claimed, and the count of each verdict."""
    real = contested(rows)
    table = pd.DataFrame({"trivial": rows.groupby("entry", sort=False)["trivial"].sum()})
    table["cells"] = real.groupby("entry").size()
    table["claimed"] = real.groupby("entry")["claimed"].sum()
    for verdict in OUTCOMES:
        table[verdict] = real[real["verdict"] == verdict].groupby("entry").size()
    return table.fillna(0).astype(int).reset_index()


def wrong_claims(rows: pd.DataFrame) -> pd.DataFrame:
    """All cells, trivial ones too, that were claimed solved and are not, the worst residual first."""
    return rows[rows["verdict"] == WRONG].sort_values("residual", ascending=False, kind="stable", na_position="first")


def reasons(rows: pd.DataFrame) -> pd.DataFrame:
    """A row per entry, verdict and reason given: cells."""
    given = rows[rows["reason"] != ""]
    return given.groupby(["entry", "verdict", "reason"], sort=False).size().rename("cells").reset_index()


def by_class(rows: pd.DataFrame) -> pd.DataFrame:
    """A row per class, entry and tolerance: cells, solved, and medians of residuals and times; worst: largest residual."""
    answers = rows.assign(
        solved=rows["verdict"] == SOLVED,
        ran=rows["verdict"] != SKIPPED,
        residual=rows["residual"].where(rows["answered"]),
        model_residual=rows["model_residual"].where(rows["answered"]),
    )
    return (
        answers.groupby(["problem_class", "entry", "tol"], sort=False)
        .agg(
            cells=("ran", "sum"),
            solved=("solved", "sum"),
            residual=("residual", "median"),
            worst=("residual", "max"),
            model_residual=("model_residual", "median"),
            fclib_error=("fclib_error", "median"),
            prepare=("prepare_time", "median"),
            solve=("solve_time", "median"),
        )
        .reset_index()
    )


def problem_classes(rows: pd.DataFrame) -> pd.DataFrame:
    """A row per class: problems, trivial ones among them, and the ranges of contacts, unknowns and condition."""
    problems = rows.sort_values("size").drop_duplicates("problem_id").sort_index()
    return (
        problems.groupby("problem_class", sort=False)
        .agg(
            problems=("problem_id", "size"),
            trivial=("trivial", "sum"),
            dimension=("dimension", "max"),
            contacts_from=("contacts", "min"),
            contacts_to=("contacts", "max"),
            size_from=("size", "min"),
            size_to=("size", "max"),
            condition=("condition", "max"),
        )
        .reset_index()
    )


class Leaders(NamedTuple):
    """Rows of a summary: who reaches the target most often (the fastest of so many equals), and the fastest of those that
    reach it on nearly as many problems."""

    most_often: pd.Series
    equals: int
    fastest: pd.Series


def leaders(summary: pd.DataFrame) -> Leaders | None:
    """The leaders over all problems; None where nobody reaches the target."""
    overall = summary[(summary["problem_class"] == ALL) & (summary["reached"] > 0)].sort_values("mean", kind="stable")
    if overall.empty:
        return None
    most = overall["reached"].max()
    equals, nearly = overall[overall["reached"] == most], overall[overall["reached"] >= NEARLY * most]
    return Leaders(equals.iloc[0], len(equals), nearly.iloc[0])


def gaps(rows: pd.DataFrame) -> int:
    """How many pairs of a problem and an entry have no row at all, as in a run cut short."""
    return rows["problem_id"].nunique() * rows["entry"].nunique() - len(rows.drop_duplicates(["problem_id", "entry"]))


def overhead(rows: pd.DataFrame) -> float | None:
    """The share of the cells' time that was spent outside prepare and solve; None where it was not measured."""
    measured = rows[rows["overhead"].notna() & (rows["wall_time"] > 0)]
    return float(measured["overhead"].sum() / measured["wall_time"].sum()) if len(measured) else None
