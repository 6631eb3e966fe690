"""A results folder as pandas tables."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from frictionbench.problems import check
from frictionbench.reports.run import Run, read_run
from frictionbench.results.store import read_manifest, read_table


@dataclass(frozen=True, repr=False)
class Results:
    """The tables of one results folder, each read when it is first used: manifest, solves, simulations and batches.

    An interrupted run has the rows that it has written. A number that was not measured is NaN. Errors: ResultsError (a
    ValueError) naming the file and the column that cannot be read. docs/columns.md describes every column.
    """

    folder: Path

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """Settings, machine, versions and times of the run."""
        return read_manifest(self.folder)

    @cached_property
    def solves(self) -> pd.DataFrame:
        """A row per cell: one problem, one solver, one tolerance."""
        return read_table(self.folder, "solves")

    @cached_property
    def simulations(self) -> pd.DataFrame:
        """A row per scene, scheme and solver run in closed loop."""
        return read_table(self.folder, "simulations")

    @cached_property
    def batches(self) -> pd.DataFrame:
        """A row per batch of small problems, solver and way to solve them all."""
        return read_table(self.folder, "batches")

    @cached_property
    def run(self) -> Run:
        """The same tables prepared for charts, as the report reads them."""
        return read_run(self.folder)

    def __repr__(self) -> str:
        return f"Results({str(self.folder)!r}: {len(self.solves)} solves, {len(self.simulations)} simulations)"


def read_results(folder: str | Path) -> Results:
    """Open the results in a folder that `frictionbench run` wrote.

    Returns a Results with `solves`, `simulations` and `batches` as pandas.DataFrame and `manifest` as a dict;
    docs/columns.md lists every column with its unit and meaning.
    Errors: ResultsError (a ValueError) if the folder does not exist, holds no run, or was written with another schema;
    InputError naming folder if it is not a path.

    >>> results = read_results("run")
    >>> results
    Results('run': 2 solves, 1 simulations)
    >>> results.solves.groupby("variant")["verdict"].value_counts().to_dict()
    {('lemke', 'solved'): 1, ('nsgs', 'solved'): 1}
    """
    results = Results(check.path("folder", folder))
    read_manifest(results.folder)
    return results
