"""The suite `robots`: steps of robots as users of simulators meet them, recorded from 24 models of other packages.

Each step is a row of robots.tsv, with the data by which `tools/robots/record.py` chose it before any step was solved. The last
columns name the methods whose answers are verified, and the largest distance of their velocities. robots.npz holds an answer to
each step under its name, and its warm start under "NAME start": the exact impulses of the previous step at the contacts that
both have. docs/robots.md describes the set.
"""

from operator import itemgetter
from pathlib import Path

import numpy as np

from frictionbench.harness.plans.hard import table
from frictionbench.harness.plans.plan import Source
from frictionbench.problems.check import Array
from frictionbench.results.conventions import ROBOT_STEP

TABLE, ARRAYS = (Path(__file__).with_name(f"robots.{suffix}") for suffix in ("tsv", "npz"))


def steps() -> tuple[Source, ...]:
    """Return all steps."""
    return tuple(Source(ROBOT_STEP, {"case": row["case"]}) for row in table(TABLE))


def one_of_each() -> tuple[Source, ...]:
    """Return for each model the step with the median number of constraint rows. Steps in which the model only settles are left
    out, because friction may affect only a few digits there."""
    models: dict[str, list[tuple[int, str]]] = {}
    for row in table(TABLE):
        if row["behaviour"] != "settle":
            size = 3 * int(row["contacts"]) + int(row["limits"]) + int(row["dry_friction"])
            models.setdefault(row["model"], []).append((size, row["case"]))
    ordered = (sorted(steps, key=itemgetter(0)) for steps in models.values())  # of equal sizes, in the order of the table
    return tuple(Source(ROBOT_STEP, {"case": steps[len(steps) // 2][1]}) for steps in ordered)


def kept(name: str) -> Array | None:
    """Read the array (nc, 3) of this name in robots.npz; None if there is none."""
    with np.load(ARRAYS, allow_pickle=False) as arrays:
        return arrays.get(name)
