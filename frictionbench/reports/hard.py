"""The share of problems that each solver solves, by what makes them hard (results.hardness).

The labels of a problem are facts measured on it; a problem has any number of them and counts under each. The shares hold for
the problems of the run: the suite `hard` was chosen by failures, so that there they compare kinds of problems, and not how
often a method fails in general.
"""

from typing import NamedTuple

import pandas as pd

from frictionbench.reports.accuracy import OVERALL
from frictionbench.reports.run import Run
from frictionbench.results.hardness import HARDNESS, hardness
from frictionbench.results.verdicts import Verdict, measured

ALL, NONE = "all", "none of these"


class HardShares(NamedTuple):
    """where: in the plane or in space. tol: the tightest tolerance. problems: how many problems each column has. meanings: of
    the columns, for their titles.

    table: a row per solver's label, the largest share of all problems first, with the share of problems solved in each column;
    NaN where a solver ran on none of them.
    """

    where: str
    tol: float
    problems: dict[str, int]
    meanings: dict[str, str]
    table: pd.DataFrame


def hard_shares(run: Run) -> list[HardShares]:
    """The share of problems that each solver solves at the tightest tolerance, by the labels of hardness that occur.

    A table for the plane and one for space, whose problems other solvers take. A solver's shares are of the problems that it
    ran on. A problem counts as solved if the residual of the exact problem is within the tolerance. A dimension in which no
    problem has a label has no table.
    """
    rows = run.tightest[measured(run.tightest)]
    found = [_shares(where, rows[rows["dimension"] == dimension]) for dimension, where in OVERALL.items()]
    return [table for table in found if table]


def _shares(where: str, rows: pd.DataFrame) -> HardShares | None:
    labels = {row["problem_id"]: hardness(row) for row in rows.drop_duplicates("problem_id").to_dict("records")}
    if not any(labels.values()):
        return None
    solved = rows["verdict"] == Verdict.SOLVED
    columns = {ALL: pd.Series(data=True, index=rows.index)}
    for name in HARDNESS:
        columns[name] = rows["problem_id"].map(lambda problem, name=name: name in labels[problem])
    columns[NONE] = rows["problem_id"].map(lambda problem: not labels[problem])
    columns = {name: inside for name, inside in columns.items() if inside.any()}
    shares = pd.DataFrame({name: solved[inside].groupby(rows["label"]).mean() for name, inside in columns.items()})
    problems = {name: rows.loc[inside, "problem_id"].nunique() for name, inside in columns.items()}
    meanings = {name: one.meaning for name, one in HARDNESS.items() if name in columns}
    ordered = shares.sort_values(ALL, ascending=False, kind="stable").rename_axis("label").reset_index()
    return HardShares(where, float(rows["tol"].min()), problems, meanings, ordered)
