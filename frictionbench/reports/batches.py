"""The report of a run of batches: the rates of many small problems on one self-contained page.

A rate is shown only if it is meaningful. The reason is shown instead if problems have no contacts, if none of them needs
friction or no contact carries load, or if some answer has no verified residual within the tolerance.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import Verdict
from frictionbench.reports.templates import write_page
from frictionbench.results.cells import repeats
from frictionbench.results.conventions import DRAWN, NEARBY, WAYS, law, scene_title
from frictionbench.results.store import read_manifest, read_table

HEADER = ("solver", "way", "start", "problems a second", "ratio")
METHOD = (  # how the figures were measured, in words for reports
    "The rate is in problems per second of processor time on one core, in the fastest round. Each problem has its own "
    + ", ".join(f"{name.replace('_', ' ')} ({low:g} to {high:g})" for name, (low, high) in DRAWN.items())
    + ". The ratio is the rate over that of single calls of the solver that is named. These are timed again in turn with "
    "each row, so that the ratio is not the quotient of two rates of the table where the machine's speed varies.",
    "Ways: "
    + "; ".join(f"{way}: {meaning.replace('`', '')}" for way, meaning in WAYS.items())
    + ". All include form, solve and, except for calls, the residual of every answer. Cold starts are from zero impulses, "
    f"warm ones from the answers of the same problems with pushes smaller by {100 * NEARBY:g} %, as from the previous step. "
    "Times exclude compilation and loading.",
    "A rate is shown only if the verified residual of every answer is within the tolerance, contacts carry load, and friction "
    "is at work. Otherwise the reason is given instead. Solvers of another law are marked, and judged by Coulomb's law as "
    "well. Rates are from one run and have no intervals; they are rounded to two digits.",
    "MuJoCo's rollout has no row, because it takes models and states and detects contacts itself. Its constraint solver is "
    "listed under calls if it is installed. Its law is soft, so that 0 % verified is not a failure.",
)


def has_batches(folder: Path) -> bool:
    """Return whether a folder holds a run of batches, which has no other problems. Errors: ResultsError if it holds no run."""
    return bool(read_manifest(folder)["settings"].get("batches"))


def write_batches(folder: Path) -> Path:
    """Write DIR/report.html; return its path. Errors: ResultsError if the folder holds no run of batches."""
    manifest: dict[str, Any] = read_manifest(folder)
    tables = rate_tables(read_table(folder, "batches"))
    facts = {"name": folder.resolve().name, "finished": "finished" in manifest, "machine": manifest.get("machine", {})}
    return write_page(folder / "report.html", "batches.html", tables=tables, header=HEADER, method=METHOD, **facts)


class RateTable(NamedTuple):
    """The rates for one set of problems and one tolerance: a title, a description of the problems, and rows below HEADER."""

    title: str
    description: str
    rows: list[list[str]]


def rate_tables(rows: pd.DataFrame) -> list[RateTable]:
    """Return the tables for the rows of batches, in their order. Cells without a result show the reason."""
    rated = []
    for (scene, parameters, tol), group in rows.groupby(["scene", "parameters", "tol"], sort=False):
        ran, (title, text) = group[group["contacts"].notna()], ("not run", "")
        if len(ran):
            facts = ran.iloc[0]
            title = f"{facts['contacts']:.0f} contacts in {'the plane' if facts['dimension'] == 2 else 'space'}"
            text = (
                f"{facts['problems']} problems, to {tol:g}; {100 * facts['active']:.0f} % of the contacts carry load, and "
                f"in {100 * facts['idle']:.0f} % of the problems friction is idle. Ratios are over single calls of "
                f"{facts['base']}."
            )
        rated.append(RateTable(f"{title}: {scene_title(scene, parameters)}", text, [*map(rate_of, group.to_dict("records"))]))
    return rated


def rate_of(row: dict[str, Any]) -> list[str]:
    """Return the entries of a row of a table of batches, as METHOD describes, or the reason and a dash where it has no rate."""
    other = law(row["model"] or "coulomb", row["dimension"])
    names = [f"{row['variant']} ({other})" if other else str(row["variant"]), str(row["way"]), str(row["start"])]
    times, singles = (repeats(row[name]) for name in ("times", "base_times"))
    if why := refusal(row) or ("" if len(times) and len(singles) else "not timed"):
        return [*names, why, "–"]
    return [*names, f"{float(f'{1 / times.min():.2g}'):,.0f}", f"{singles.min() / times.min():.2g}"]


def refusal(row: dict[str, Any]) -> str:
    """Return why the rate of a row is not meaningful, or an empty text."""
    if pd.isna(row["verified"]):
        return f"{row['verdict']}: {row['reason']}" if row["reason"] else str(row["verdict"])
    if not row["contacts"] > 0:
        return "no contacts"
    if row["idle"] == 1 or not row["active"] > 0:
        return "friction is idle in all problems"
    if row["verified"] < 1:
        return f"{np.floor(1000 * row['verified']) / 10:.3g} % verified"
    if not row["residual"] <= row["tol"]:
        return "residual above the tolerance"
    return "" if row["verdict"] == Verdict.SOLVED else str(row["verdict"])
