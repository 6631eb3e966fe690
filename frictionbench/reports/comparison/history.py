"""Runs over time: for each solver, a line per run that measured it, with verdicts, work and time over the cells that all these
runs measured."""

from collections import Counter
from collections.abc import Iterable
from functools import reduce
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import ACCEPTED
from frictionbench.reports.drawing.text import escaped, pipe, seconds
from frictionbench.results.cells import Cells, format_counts, parse_counts, read
from frictionbench.results.files import ResultsError


class Line(NamedTuple):
    """A solver in one run: the verdicts of its cells, and over the cells that every run solves, the sums of the counters and
    the geometric mean of the times, s."""

    run: Cells
    verdicts: Counter[str]
    work: Counter[str]
    time: float


def lines(paths: Iterable[Path]) -> dict[str, list[Line]]:
    """Return each solver's lines in the runs, the oldest first. paths: results folders or baselines.

    Errors: ResultsError if one cannot be read, or if nothing was measured in any.
    """
    runs = sorted(map(read, paths), key=lambda run: run.made)
    measured = [(run, run.measured) for run in runs]
    lines_by_solver = {}
    for variant in sorted({variant for _, cells in measured for variant in cells["variant"]}):
        of_variant = [(run, cells[cells["variant"] == variant]) for run, cells in measured if variant in set(cells["variant"])]
        common = reduce(pd.Index.intersection, [cells.index for _, cells in of_variant])
        good = [key for key in common if all(cells["verdict"][key] in ACCEPTED for _, cells in of_variant)]
        lines_by_solver[variant] = [_line(run, cells.loc[common], good) for run, cells in of_variant]
    if not lines_by_solver:
        raise ResultsError("history: no cell was measured in these runs")
    return lines_by_solver


def history(lines_by_solver: dict[str, list[Line]]) -> str:
    """Return the lines as a Markdown table."""
    rows = []
    for variant, of_variant in lines_by_solver.items():
        for i, line in enumerate(of_variant):
            verdicts = ", ".join(f"{count} {verdict}" for verdict, count in line.verdicts.most_common())
            results = (str(line.verdicts.total()), verdicts, format_counts(dict(line.work)), seconds(line.time))
            names = ("" if i else variant, str(line.run.path), line.run.made[:10], line.run.code)
            rows.append([*map(escaped, (*names, *results))])
    return "\n".join(pipe(("solver", "run", "made", "suite's code", "cells", "verdicts", "work", "time"), rows))


def _line(run: Cells, cells: pd.DataFrame, good: list[str]) -> Line:
    work: Counter[str] = Counter()
    for text in cells.loc[good, "work"]:
        work.update(parse_counts(text))
    mean = float(np.exp(np.log(cells.loc[good, "seconds"]).mean())) if len(good) else np.nan
    return Line(run, Counter(cells["verdict"]), work, mean)
