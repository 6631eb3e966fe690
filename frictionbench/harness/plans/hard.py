"""The suite `hard`, which ranks robustness: problems with a known solution on which at least one serious method fails.

The candidates, in candidates.tsv, are families at their edges: "around p = 0" has Painlevé's rod near the friction at which
1 + 3 cos^2 = 3 mu sin cos of its angle, "recorded" what was recorded elsewhere. The families, their grids and FEWEST were
settled after a look at which problems fail, so that there are enough; which candidates are in the suite follows from a run of
all methods at one tolerance:

    python -m tools.admit DIR     runs the candidates in DIR, or goes on, and writes hard.tsv

A candidate is *admissible* if a solution is known (by a theorem, see problems.analysis.thresholds, by counting all solutions,
or because a verified answer is one, which is then kept in hard.npz), if friction is at work (it is neither trivial nor idle),
and if the rounding floor of its best answer is at most a tenth of the tolerance. A method *fails* on it if it ends with a
verdict other than `solved`; a timeout does not count, since it depends on the machine, and neither does an LCP in space, which
is another model. Of each family and for each method the suite has the FEWEST admissible candidates with the fewest contacts on
which the method fails.

The rule treats all methods alike. But the problems were chosen by their failures: a method's share solved in this suite says on
what it fails, not how often it fails in general.
"""

import csv
import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.problems.check import Array

# One or two of every kind of method for Coulomb's law that simulators and libraries are built on.
METHODS = (
    *("lemke", "dantzig", "path_search", "fischer_newton"),  # in the plane, where the friction LCP is Coulomb's law
    *("hybrid", "interior_point", "nsgs", "proximal_newton"),
)
TOL = 1e-8
LIMIT = 10.0  # seconds
FEWEST = 4
CANDIDATES, ADMITTED, ANSWERS = (Path(__file__).with_name(name) for name in ("candidates.tsv", "hard.tsv", "hard.npz"))


def hard() -> Plan:
    """Problems on which at least one serious method fails, to compare robustness."""
    return Plan(
        suite="hard",
        sources=tuple(Source(row["scene"], json.loads(row["parameters"])) for row in admitted()),
        solvers=METHODS[:-1],
        spatial_solvers=METHODS,
        tolerances=(1e-4, TOL),
        time_limit=5.0,
        expects="ten minutes",
    )


def candidates(dimension: int) -> Plan:
    """All candidates of a dimension, with the methods whose model is exact there."""
    return Plan(
        suite=f"candidates for hard, dimension {dimension}",
        sources=tuple(source for family in families(dimension).values() for source in family),
        solvers=METHODS[:-1] if dimension == 2 else METHODS[4:],
        tolerances=(TOL,),
        time_limit=LIMIT,
    )


def families(dimension: int) -> dict[str, list[Source]]:
    """The candidates by family: a source for every combination of the values in a row of candidates.tsv."""
    found: dict[str, list[Source]] = {}
    for row in table(CANDIDATES):
        if int(row["dimension"]) == dimension:
            grid = json.loads(row["grid"])
            chosen = (dict(zip(grid, values, strict=True)) for values in product(*grid.values()))
            found.setdefault(row["family"], []).extend(Source(row["scene"], each, repeats=1) for each in chosen)
    return found


def admitted() -> list[dict[str, str]]:
    """The rows of hard.tsv: family, scene, parameters, contacts, known, residual, floor, answer, failed."""
    return table(ADMITTED)


def table(path: Path) -> list[dict[str, str]]:
    """The lines of a table of text, by the names in its first line."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def kept_answer(row: dict[str, str]) -> Array | None:
    """The verified impulses (nc, d) kept for a row of hard.tsv; None where a solution is known by theory alone."""
    if not row["answer"]:
        return None
    with np.load(ANSWERS, allow_pickle=False) as answers:
        return answers[answer_key(row)]


def answer_key(row: dict[str, Any]) -> str:
    """The name of a row's answer in hard.npz. row: with scene and parameters."""
    return f"{row['scene']} {row['parameters']}"
