"""The cells of a run as compact data, from which the page's own script ranks the solvers on problems that a reader selects."""

from typing import Any

import numpy as np

from frictionbench.reports.run import Run
from frictionbench.results.conventions import RankBy
from frictionbench.results.verdicts import Verdict, measured

MOST_CELLS = 20_000  # on a page: a megabyte; a run of more is filtered from Python
DIGITS = 3  # of times and residuals


def cells(run: Run) -> dict[str, Any]:
    """The ranked cells that ran: names by their numbers, and for each cell [label, scene, family, problem, stratum, dimension,
    contacts, tol, time from bodies, time from the form, time limit, residual, solved]; empty for a run of too many cells, or
    of one."""
    rows = run.ranked[measured(run.ranked)]
    if not 1 < len(rows) <= MOST_CELLS:
        return {}
    names = {name: sorted(rows[name].fillna("").astype(str).unique()) for name in ("label", "scene", "family")}
    columns = [
        rows[name].fillna("").astype(str).map({text: k for k, text in enumerate(known)}) for name, known in names.items()
    ]
    columns += [
        rows["problem_id"],
        rows["stratum"].astype("category").cat.codes,
        rows["dimension"],
        rows["contacts"],
        rows["tol"],
    ]
    columns += [by.time(rows) for by in RankBy] + [rows["time_limit"], rows["residual"]]
    table = np.column_stack([*columns, rows["verdict"] == Verdict.SOLVED]).astype(float)
    colours = [run.looks[label].colour if label in run.looks else "" for label in names["label"]]
    return {**names, "colours": colours, "cells": [[_short(value) for value in row] for row in table.tolist()]}


def _short(value: float) -> float | None:
    """A number that JSON has, with few digits; an int where it is whole."""
    if not np.isfinite(value):
        return None
    return int(value) if value == int(value) and abs(value) < 1e9 else float(f"{value:.{DIGITS}g}")
