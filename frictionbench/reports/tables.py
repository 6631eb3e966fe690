"""The report's tables: which solver solves which problems, and how fast."""

from collections.abc import Collection
from typing import Any

import pandas as pd

from frictionbench.reports.run import Run
from frictionbench.results.conventions import ENDINGS, endings
from frictionbench.results.verdicts import Verdict, measured

CLOCK_MARGIN = 0.1  # relative difference of a library's own clock from solve_time that is larger than the overhead of a call


def solvability(run: Run) -> pd.DataFrame:
    """A row per label: left_out (cells of trivial and idle problems, not counted in the others), cells, claimed, each verdict,
    with the answers to another law and to a polygon apart, and error: the median residual of these, by Coulomb's law."""
    real = run.ranked.assign(ending=endings(run.ranked))
    table = pd.DataFrame({"left_out": run.rows.groupby("label", sort=False).size()})
    table["cells"] = real.groupby("label").size()
    table["claimed"] = real.groupby("label")["claimed"].sum()
    for ending in ENDINGS:
        table[ending] = real[real["ending"] == ending].groupby("label").size()
    table = table.fillna(0).astype(int)
    table["left_out"] -= table["cells"]
    return table.assign(error=model_errors(run.ranked)).reset_index()


def model_errors(rows: pd.DataFrame) -> "pd.Series[float]":
    """By label the median residual, by Coulomb's law, of the answers that solve another law or a polygon in its place."""
    return rows[rows["verdict"] == Verdict.RELAXED].groupby("label")["residual"].median()


def wrong_claims(run: Run) -> pd.DataFrame:
    """All cells with the verdict wrong, those of trivial problems included, the largest residual first."""
    wrong = run.rows[run.rows["verdict"] == Verdict.WRONG]
    return wrong.sort_values("residual", ascending=False, kind="stable", na_position="first")


def reasons(run: Run) -> pd.DataFrame:
    """A row per label, verdict and reason: cells."""
    given = run.rows[run.rows["reason"] != ""]
    given = given.assign(verdict=endings(given))
    return given.groupby(["label", "verdict", "reason"], sort=False).size().rename("cells").reset_index()


def by_class(run: Run) -> pd.DataFrame:
    """A row per class, label and tolerance: cells, solved, medians of residuals (1) and times (s), worst (largest residual)."""
    rows = run.ranked
    answers = rows.assign(
        solved=rows["verdict"] == Verdict.SOLVED,
        ran=measured(rows),
        residual=rows["residual"].where(rows["answered"]),
        model_residual=rows["model_residual"].where(rows["answered"]),
    )
    return (
        answers.groupby(["problem_class", "label", "tol"], sort=False)
        .agg(
            cells=("ran", "sum"),
            solved=("solved", "sum"),
            residual=("residual", "median"),
            worst=("residual", "max"),
            model_residual=("model_residual", "median"),
            fclib_error=("fclib_error", "median"),
            form=("form_time", "median"),
            setup=("setup_time", "median"),
            solve=("solve_time", "median"),
        )
        .reset_index()
    )


def problem_classes(run: Run) -> pd.DataFrame:
    """A row per class, grouped by scene and ordered by size: problems, how many are trivial and how many idle, the ranges of
    contacts and unknowns, and the largest condition."""
    problems = run.rows.sort_values("size").drop_duplicates("problem_id").sort_index()
    order = {scene: i for i, scene in enumerate(problems["scene"].unique())}
    problems = problems.assign(order=problems["scene"].map(order)).sort_values(["order", "size"], kind="stable")
    return (
        problems.groupby("problem_class", sort=False)
        .agg(
            problems=("problem", lambda names: int((names != "").sum())),
            trivial=("trivial", "sum"),
            idle=("idle", "sum"),
            dimension=("dimension", "max"),
            contacts_from=("contacts", "min"),
            contacts_to=("contacts", "max"),
            size_from=("size", "min"),
            size_to=("size", "max"),
            condition=("condition", "max"),
        )
        .reset_index()
    )


def best_first(summary: pd.DataFrame, problem_class: str) -> pd.DataFrame:
    """The rows of a class in a summary by label, the largest share of the problems solved first, the faster among equals."""
    own = summary[summary["problem_class"] == problem_class].set_index("label")
    return own.assign(share=own["share"].round(9)).sort_values(["share", "mean"], ascending=[False, True])


def matrix(summary: pd.DataFrame, problem_class: str, classes: Collection[str]) -> list[tuple[str, dict[str, Any]]]:
    """The labels of a class, the best first, each with its row for it and for each of other classes."""
    own = summary[summary["problem_class"].isin([problem_class, *classes])]
    cells = {label: group.set_index("problem_class").to_dict("index") for label, group in own.groupby("label")}
    return [(label, cells[label]) for label in best_first(summary, problem_class).index]


def ranking(summaries: dict[float, pd.DataFrame], problem_class: str) -> list[tuple[str, list[dict[str, Any]]]]:
    """The labels of a class, best at the finest target first, each with its row at each target."""
    own = {target: best_first(table, problem_class) for target, table in summaries.items()}
    return [(label, [table.loc[label].to_dict() for table in own.values()]) for label in own[min(own)].index]


def gaps(run: Run) -> int:
    """The number of pairs of a problem and a label that have no row, as in a run that has not finished.

    In the plane and in space a plan may have other solvers: pairs are counted for each dimension.
    """
    pairs = run.ranked.drop_duplicates(["problem_id", "label"])
    return sum(rows["problem_id"].nunique() * rows["label"].nunique() - len(rows) for _, rows in pairs.groupby("dimension"))


def clocks(run: Run) -> pd.DataFrame:
    """A row per label whose library measures its own time: medians of solve_time and clock_time (s) and of their ratio;
    differs: whether the ratio differs from one by more than CLOCK_MARGIN."""
    rows = run.ranked[run.ranked["clock_time"].notna() & run.ranked["solve_time"].notna()]
    rows = rows.assign(solve_time=rows["call_time"].fillna(rows["solve_time"]))  # of a library in another process, the call
    ratio = rows["solve_time"] / rows["clock_time"].clip(lower=1e-7)
    groups = rows.assign(ratio=ratio).groupby("label", sort=False)
    table = groups[["solve_time", "clock_time", "ratio"]].median()
    return table.assign(differs=(table["ratio"] - 1).abs() > CLOCK_MARGIN).reset_index()


def overhead(run: Run) -> float | None:
    """The share of the cells' time spent outside form, setup and solve; None if it was not measured."""
    rows = pd.concat([table[["overhead", "wall_time"]] for table in (run.rows, run.simulations)])
    measured = rows[rows["overhead"].notna() & (rows["wall_time"] > 0)]
    return float(measured["overhead"].sum() / measured["wall_time"].sum()) if len(measured) else None
