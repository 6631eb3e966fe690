"""The suite `hard`, which ranks robustness: problems with a known solution on which at least one serious method fails.

hard.tsv is written by `python -m tools.admit`, which runs all methods at one tolerance on candidates: families at their edges.
The families, their grids and FEWEST were settled after a look at which problems fail, so that there are enough.

A candidate is *admissible* if a solution is known (by a theorem, see problems.analysis.thresholds, by counting all solutions,
or because a verified answer is one, which is then kept, if friction is at work (it is neither trivial nor idle),
and if the rounding floor of its best answer is at most a tenth of the tolerance. A method *fails* on it if it ends with a
verdict other than `solved`; a timeout does not count, since it depends on the machine, and neither does an LCP in space, which
is another model. Of each family and for each method the suite has the FEWEST admissible candidates with the fewest contacts on
which the method fails.

The rule treats all methods alike. But the problems were chosen by their failures: a method's share solved in this suite says on
what it fails, not how often it fails in general.
"""

import csv
import json
from pathlib import Path

from frictionbench.harness.plans.plan import Plan, Source

# One or two of every kind of method for Coulomb's law that simulators and libraries are built on.
METHODS = (
    *("lemke", "dantzig", "path_search", "fischer_newton"),  # in the plane, where the friction LCP is Coulomb's law
    *("hybrid", "interior_point", "nsgs", "proximal_newton"),
)
TOL = 1e-8
FEWEST = 4
ADMITTED = Path(__file__).with_name("hard.tsv")


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


def admitted() -> list[dict[str, str]]:
    """The rows of hard.tsv: family, scene, parameters, contacts, known, residual, floor, answer, failed."""
    return table(ADMITTED)


def table(path: Path) -> list[dict[str, str]]:
    """The lines of a table of text, by the names in its first line."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
