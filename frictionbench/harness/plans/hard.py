"""The suite `hard`, which ranks robustness: problems with a known solution on which at least one serious method fails.

hard.tsv is written by `python -m tools.admit`, which runs all methods at one tolerance on candidates from the extremes of
families. docs/hard.md states the rule by which it chooses, and what the shares solved in this suite do not mean.
"""

import csv
import json
from pathlib import Path

from frictionbench.harness.plans.plan import Plan, Source

# One or two of each kind of method for Coulomb's law on which simulators and libraries are based.
METHODS = (
    *("lemke", "dantzig", "path_search", "fischer_newton"),  # for the plane, where the LCP is equivalent to Coulomb's law
    *("hybrid", "interior_point", "nsgs", "proximal_newton"),
)
TOL = 1e-8
ADMITTED = Path(__file__).with_name("hard.tsv")  # family, scene, parameters, contacts, known, residual, floor, answer, failed


def hard() -> Plan:
    """Problems on which at least one serious method fails, to compare robustness."""
    return Plan(
        suite="hard",
        sources=tuple(Source(row["scene"], json.loads(row["parameters"])) for row in table(ADMITTED)),
        solvers=METHODS[:-1],
        spatial_solvers=METHODS,
        tolerances=(1e-4, TOL),
        time_limit=5.0,
        expects="ten minutes",
    )


def table(path: Path) -> list[dict[str, str]]:
    """Read a tab-separated table as one dict per row, with the names in its first line as keys."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
