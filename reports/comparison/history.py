"""Runs over time: for each solver a line per run that measured it, with verdicts, work and time over the cells that all of
these runs measured."""

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from rich.table import Table
from rich.text import Text

from frictionbench.reports.drawing.text import seconds
from frictionbench.results.cells import format_counts, parse_counts, read
from frictionbench.results.files import ResultsError
from frictionbench.results.printable import printable
from frictionbench.results.verdicts import ACCEPTED


def history(paths: Iterable[Path]) -> Table:
    """A table of the runs, results folders or baselines, the oldest first.

    Errors: ResultsError if one cannot be read, or if nothing was measured in any.
    """
    runs = sorted(map(read, paths), key=lambda run: run.made)
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("solver", "run", "made", "code", "cells", "verdicts", "work", "time"):
        table.add_column(name, overflow="fold")
    measured = [(run, run.measured) for run in runs]
    for variant in sorted({variant for _, cells in measured for variant in cells["variant"]}):
        own = [(run, cells[cells["variant"] == variant]) for run, cells in measured if variant in set(cells["variant"])]
        common = _common([cells for _, cells in own])
        good = [key for key in common if all(cells["verdict"][key] in ACCEPTED for _, cells in own)]
        for i, (run, cells) in enumerate(own):
            first = Text("" if i else printable(variant))
            table.add_row(
                first, Text(str(run.path)), printable(run.made[:10]), Text(printable(run.code)), *_line(cells.loc[common], good)
            )
    if not table.row_count:
        raise ResultsError("history: no cell was measured in these runs")
    return table


def _common(tables: Sequence[pd.DataFrame]) -> pd.Index:
    common = tables[0].index
    for table in tables[1:]:
        common = common.intersection(table.index)
    return common


def _line(cells: pd.DataFrame, good: list[str]) -> list[str]:
    """The number of cells, the verdicts, and over the cells in `good` the sums of counters and the geometric mean time."""
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in Counter(cells["verdict"]).most_common())
    work: Counter[str] = Counter()
    for line in cells.loc[good, "work"]:
        work.update(parse_counts(line))
    times = np.log(cells.loc[good, "seconds"])
    mean = float(np.exp(times.mean())) if len(good) else np.nan
    return [str(len(cells)), verdicts, format_counts(dict(work)), seconds(mean)]
