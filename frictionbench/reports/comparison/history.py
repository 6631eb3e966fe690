"""Runs over time: for each solver, a line per run that measured it, with verdicts, work and time over the cells that all these
runs measured."""

from collections import Counter
from collections.abc import Iterable
from functools import reduce
from pathlib import Path

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import ACCEPTED
from frictionbench.reports.drawing.text import escaped, pipe, seconds
from frictionbench.results.cells import format_counts, parse_counts, read
from frictionbench.results.files import ResultsError

HEADER = ("solver", "run", "made", "suite's code", "cells", "verdicts", "solved by all", "work", "time")
NOTE = "Of each solver, cells are those that all its runs measured; work and time are of those that all its runs solve."


def history(paths: Iterable[Path]) -> str:
    """Return each solver's lines in the runs, the oldest first, as a Markdown table. paths: results folders or baselines.

    Errors: ResultsError if one cannot be read, or if nothing was measured in any.
    """
    measured = [(run, run.measured) for run in sorted(map(read, paths), key=lambda run: run.made)]
    rows = []
    for variant in sorted({variant for _, cells in measured for variant in cells["variant"]}):
        of_variant = [(run, cells[cells["variant"] == variant]) for run, cells in measured if variant in set(cells["variant"])]
        common = reduce(pd.Index.intersection, [cells.index for _, cells in of_variant])
        solved = [key for key in common if all(cells["verdict"][key] in ACCEPTED for _, cells in of_variant)]
        for i, (run, cells) in enumerate(of_variant):
            names = ("" if i else variant, str(run.path), run.made[:10], run.code)
            counts = Counter(cells.loc[common, "verdict"]).most_common()
            verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts)
            results = (str(len(common)), verdicts, str(len(solved)), *_spent(cells.loc[solved]))
            rows.append([*map(escaped, (*names, *results))])
    if not rows:
        raise ResultsError("history: no cell was measured in these runs")
    return "\n".join([*pipe(HEADER, rows), "", NOTE])


def _spent(cells: pd.DataFrame) -> tuple[str, str]:
    """Return the sums of the cells' counters and the geometric mean of their times, as text."""
    work: Counter[str] = Counter()
    for text in cells["work"]:
        work.update(parse_counts(text))
    mean = float(np.exp(np.log(cells["seconds"]).mean())) if len(cells) else np.nan
    return format_counts(dict(work)), seconds(mean)
