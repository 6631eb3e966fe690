"""A run as reports read it: its manifest, and its tables with added columns. Page, paper and charts share this object.

Columns added to the solves table:

    label           the variant of a solver, with an asterisk if it is a portfolio, with "(single precision)" if it was skipped
                    for that at some tolerance and its name does not say so, with the start unless it is cold, and with the
                    host if there are several, so that times of two machines are never combined
    problem_id      a number for the problem of one time step
    problem_class   the scene, with its range of sizes if the scene occurs in several
    stratum         the stratum for weights, see reports.accuracy
    time            the time by which the run ranks, s, see results.conventions
    answered        whether there is an answer that was verified and timed
    own_solved      whether it solves the exact problem or the solver's own model to the tolerance
    unread, bare    whether the source yielded no problem, or none with contacts, as an LCP
    infeasible      whether the problem is proved to have no solution
    several_outcomes    whether solutions with several velocities were found or enumerated
    robot           whether the problem is a step of a robot
    cluster         a group of similar problems: the scene or, for steps of robots, the model

Problems with one of EXCLUSIONS are excluded from rankings: `Run.ranked` leaves them out.
"""

import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import SINGLE, Verdict, measured
from frictionbench.reports.accuracy import OVERALL, strata, summary, targets, times_to
from frictionbench.reports.drawing.style import Look, looks
from frictionbench.results.commands import sources
from frictionbench.results.conventions import ANOTHER_OUTCOME, COLD, ROBOT_STEP, RankBy, json_object
from frictionbench.results.files import read_parsed
from frictionbench.results.histories import ConvergenceHistory, read_histories
from frictionbench.results.maps import GridPoint, maps_of, thresholds_file
from frictionbench.results.store import read_manifest, read_table

BANDS = (100, 1000)  # unknowns of the friction LCP: dense methods are faster below, sparse ones above
PORTFOLIO = "*"
NO_ANSWER = (Verdict.TIMEOUT, Verdict.CRASHED, Verdict.SKIPPED)
EXCLUSIONS = {  # columns that exclude problems from rankings; the first that holds is counted
    "unread": "that cannot be read or made",
    "bare": "given as an LCP",
    "infeasible": "proved infeasible",
    "trivial": "trivial",
    "idle": "idle",
}
_IDENTITY = ["scene", "parameters", "step", "phase", "problem"]


@dataclass(frozen=True, eq=False)
class Run:
    """The contents of a results folder. Values that several readers need are computed once.

    rows: the solves table; simulations: the simulations table without maps in closed loop, which are in map_simulations;
    thresholds: points on each threshold, by map and name. rank_by: the time by which solvers are ranked; budget: the reader's
    time for each problem, s, if any.
    """

    manifest: dict[str, Any]
    rows: pd.DataFrame
    simulations: pd.DataFrame
    map_simulations: pd.DataFrame = field(default_factory=pd.DataFrame)
    histories: list[ConvergenceHistory] = field(default_factory=list)
    thresholds: dict[str, dict[str, list[GridPoint]]] = field(default_factory=dict)
    folder: Path = Path()
    rank_by: RankBy = RankBy.BODIES
    budget: float | None = None

    def ranked_by(self, rank_by: RankBy) -> "Run":
        """Return the run ranked by this time."""
        rows = self.rows.assign(time=rank_by.time(self.rows))
        return self if rank_by is self.rank_by else replace(self, rank_by=rank_by, rows=rows)

    @cached_property
    def ranked(self) -> pd.DataFrame:
        """The rows of problems that no exclusion removes."""
        return self.rows[~self.rows[list(EXCLUSIONS)].any(axis=1)]

    @cached_property
    def outside(self) -> set[str]:
        """The labels of solvers that use an outside library: those whose version is not that of this package."""
        versions = self.rows["version"].fillna("")
        return set(self.rows.loc[~versions.isin(["", self.manifest.get("versions", {}).get("frictionbench", "")]), "label"])

    @property
    def tightest(self) -> pd.DataFrame:
        """The rows of `ranked` at the tightest tolerance."""
        return self.ranked[self.ranked["tol"] == self.ranked["tol"].min()]

    @cached_property
    def plugins(self) -> dict[str, str]:
        """The sources of plug-ins' solvers, see results.commands."""
        return sources(self.manifest["settings"])

    @cached_property
    def looks(self) -> dict[str, Look]:
        """The look of every label that ran."""
        tables = (self.rows, self.simulations)
        return looks(label for table in tables for label in table.loc[measured(table), "label"])

    @cached_property
    def portfolios(self) -> dict[str, str]:
        """For each portfolio that has a row, the solvers that it may run."""
        rows = pd.concat([table[["solver", "members"]] for table in (self.rows, self.simulations)]).drop_duplicates("solver")
        return {solver: members for solver, members in rows.fillna("").itertuples(index=False) if members}

    @cached_property
    def times(self) -> dict[float, pd.DataFrame]:
        """For each target the times to it, per problem and label, see reports.accuracy."""
        return {target: times_to(self.ranked, target, self.rank_by) for target in targets(self.ranked)}

    @property
    def overall(self) -> list[str]:
        """The classes of OVERALL that the run has."""
        return [name for dimension, name in OVERALL.items() if (self.ranked["dimension"] == dimension).any()]

    @property
    def outer_targets(self) -> list[float]:
        """The loosest and the tightest target; one entry if they are equal."""
        return sorted({max(self.times), min(self.times)}, reverse=True)

    @cached_property
    def summaries(self) -> dict[float, pd.DataFrame]:
        """For each target the summary of its times, per class and label."""
        return {target: summary(times) for target, times in self.times.items()}


def read_run(folder: Path, rank_by: RankBy = RankBy.BODIES, budget: float | None = None) -> Run:
    """Read the run in a results folder. rank_by: the time by which it ranks. budget: for each problem, s.

    Errors: results.files.ResultsError if it is not one or a file in it cannot be read.
    """
    manifest = read_manifest(folder)
    specs = maps_of(manifest)
    loops = {
        (spec.scene, spec.scheme, json.dumps(spec.at(point), sort_keys=True))
        for spec in specs
        for point in (spec.grid_points() if spec.steps else ())
    }
    simulations = annotate_simulations(read_table(folder, "simulations"))
    where = zip(simulations["scene"], simulations["scheme"], simulations["parameters"], strict=True)
    mapped = np.array([simulation in loops for simulation in where], dtype=bool)
    thresholds = {spec.name: read_parsed(thresholds_file(folder, spec), dict[str, list[GridPoint]], {}) for spec in specs}
    solves = annotate(read_table(folder, "solves"))
    both = simulations[~mapped], simulations[mapped]
    return Run(manifest, solves, *both, read_histories(folder), thresholds, folder, budget=budget).ranked_by(rank_by)


def annotate(solves: pd.DataFrame) -> pd.DataFrame:
    """Return a copy of the solves table with the columns listed above."""
    rows = solves.reset_index(drop=True)
    texts = ["scene", "parameters", "solver", "variant", "model", "verdict", "reason"]
    texts += ["phase", "problem", "start", "key", "host"]
    rows[texts] = rows[texts].fillna("")
    for name in ("trivial", "idle", "claimed"):
        rows[name] = rows[name].eq(True)
    rows["unread"], rows["bare"] = rows["problem"] == "", rows["contacts"].isna()
    rows["infeasible"] = rows["proved_infeasible"].eq(True)
    rows["several_outcomes"] = outcomes(rows).groupby(rows["problem"]).transform("max") > 1
    rows["robot"] = rows["scene"] == ROBOT_STEP
    models = rows["parameters"].map(lambda text: str(json_object(text).get("case", "")).partition("-")[0])
    rows["cluster"] = rows["scene"].where(~rows["robot"], rows["scene"] + " " + models)
    rows["label"] = rows["variant"].where(rows["start"].isin(["", COLD]), rows["variant"] + ", " + rows["start"])
    rows["label"] += _mark(rows)
    if len(set(rows["host"])) > 1:
        rows["label"] += " on " + rows["host"]
    rows["problem_id"] = rows.groupby(_IDENTITY, dropna=False, sort=False).ngroup()
    rows["problem_class"] = _classes(rows)
    rows["stratum"] = strata(rows)
    rows["time"] = RankBy.BODIES.time(rows)
    rows["answered"] = ~rows["verdict"].isin(NO_ANSWER) & np.isfinite(rows["residual"]) & np.isfinite(rows["time"])
    judged = rows["answered"] & (rows["verdict"] != Verdict.UNJUDGEABLE)
    rows["own_solved"] = judged & (rows[["residual", "model_residual"]].min(axis=1) <= rows["tol"])
    return rows


def outcomes(rows: pd.DataFrame) -> "pd.Series[float]":
    """Return for each row a lower bound on the problem's number of outcomes, from the answers of the run and the reference, or
    from enumeration if no answer has a distance from the reference (column outcome_distance, problems.analysis.outcomes).

    Velocities whose distances differ by more than ANOTHER_OUTCOME differ by as much; those at one distance may differ too.
    """
    distances = rows[rows["outcome_distance"].notna()].groupby("problem")["outcome_distance"]
    # One for the reference, at distance 0, and one for each gap.
    known = distances.agg(lambda own: 1 + (np.diff(np.sort(own.to_numpy(float)), prepend=0.0) > ANOTHER_OUTCOME).sum())
    return rows["problem"].map(known).fillna(rows["outcomes"]).astype(float)


def annotate_simulations(simulations: pd.DataFrame) -> pd.DataFrame:
    """Return a copy of the simulations table with the column label."""
    rows = simulations.reset_index(drop=True)
    texts = ["scene", "parameters", "variant", "verdict", "reason", "scheme", "key"]
    rows[texts] = rows[texts].fillna("")
    return rows.assign(label=rows["variant"] + _mark(rows))


def _mark(rows: pd.DataFrame) -> pd.Series:
    """Return the marks that follow the name of a portfolio and of a single-precision solver."""
    single = set(rows.loc[rows["reason"].str.startswith(SINGLE), "variant"])
    words = rows["variant"].map(lambda variant: f" ({SINGLE})" if variant in single and "single" not in variant else "")
    return rows["members"].fillna("").ne("").map({True: PORTFOLIO, False: ""}) + words


def _classes(rows: pd.DataFrame) -> pd.Series:
    size = rows.groupby(["scene", "parameters"])["size"].transform("max")  # a skipped cell may not know its size
    band = pd.Series(np.searchsorted(BANDS, size.fillna(0), side="right"), index=rows.index)
    low, high = BANDS
    names = band.map({0: f", n < {low}", 1: f", n < {high}", 2: f", n from {high}"})
    several = band.groupby(rows["scene"]).transform("nunique") > 1
    return rows["scene"] + names.where(several, "")
