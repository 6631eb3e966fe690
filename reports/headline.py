"""The first sentences of the report: which solver reaches the finest target most often, and which one reaches the coarsest
fastest."""

from typing import NamedTuple

import pandas as pd

from frictionbench.reports.accuracy import ALL
from frictionbench.reports.drawing.text import power, seconds
from frictionbench.reports.run import Run

MUCH_FORM = 0.2  # share of form in the time, above which the formulation by this suite may decide the rank
MOST_SHARE = 0.9  # share of the best solver's number of problems that counts as nearly as many


class Leaders(NamedTuple):
    """Rows of a summary: the solver that reaches the target most often (the fastest of `equals` solvers), and the fastest of
    those that reach it on nearly as many problems."""

    most_often: pd.Series
    equals: int
    fastest: pd.Series


def leaders(summary: pd.DataFrame) -> Leaders | None:
    """The leaders over all problems; None if no solver reaches the target."""
    overall = summary[(summary["problem_class"] == ALL) & (summary["reached"] > 0)].sort_values("mean", kind="stable")
    if overall.empty:
        return None
    most = overall["reached"].max()
    equals, nearly = overall[overall["reached"] == most], overall[overall["reached"] >= MOST_SHARE * most]
    return Leaders(equals.iloc[0], len(equals), nearly.iloc[0])


def headline(run: Run) -> list[str]:
    """The two sentences."""
    found = {target: leaders(table) for target, table in run.summaries.items()}
    finest, coarsest = min(found), max(found)
    if not (best := found[finest]):
        lines = [f"No solver reaches a verified residual of {power(finest)} on any ranked problem."]
    else:
        first, equals = best.most_often, best.equals
        on = f"on {first['reached']} of {first['problems']} ranked problems"
        if equals > 1:
            tie = f"{equals} solvers reach a verified residual of {power(finest)} equally often, {on}; the fastest of them is"
            lines = [f"{tie} {first['label']}, with a mean of {seconds(first['mean'])}{_form(first)}."]
        else:
            alone = f"{first['label']} reaches a verified residual of {power(finest)} most often: {on}"
            lines = [f"{alone}, with a mean of {seconds(first['mean'])}{_form(first)}."]
    if best := found[coarsest]:
        fastest = best.fastest
        lines.append(
            f"For {power(coarsest)}, {fastest['label']} is the fastest of the solvers that reach it on nearly as many problems "
            f"as the best: on {fastest['reached']} of {fastest['problems']}, with a mean of {seconds(fastest['mean'])}"
            f"{_form(fastest)}."
        )
    return lines


def _form(row: pd.Series) -> str:
    """The share of form in a solver's time."""
    return f" ({100 * row['written']:.0f} % of it for writing the problem in the solver's form)"
