"""The suite `robots`: steps of robots as users of simulators have them, recorded of 24 models of other packages.

They stand in robots.tsv, a line each with what the choice was made by, and were chosen by `tools/robots/record.py` before any
of them was solved; its last columns name the methods whose answers are verified, and how far their velocities are apart.
robots.npz holds an answer of each by the name of the step, and under "NAME start" the exact impulses of the step before at the
contacts that it had too: its warm start. docs/robots.md describes the set.
"""

from pathlib import Path

import numpy as np

from frictionbench.harness.plans.hard import table
from frictionbench.harness.plans.plan import Source
from frictionbench.problems.check import Array

TABLE, ARRAYS = (Path(__file__).with_name(f"robots.{suffix}") for suffix in ("tsv", "npz"))
SCENE = "robot_step"


def chosen() -> list[dict[str, str]]:
    """The lines of robots.tsv."""
    return table(TABLE)


def steps() -> tuple[Source, ...]:
    """All of them."""
    return tuple(Source(SCENE, {"case": row["case"]}) for row in chosen())


def one_of_each() -> tuple[Source, ...]:
    """The step with the median number of rows of each model, of those in which it does not just settle: there friction may be
    at work by a few digits only."""
    models: dict[str, list[dict[str, str]]] = {}
    for row in chosen():
        if row["behaviour"] != "settle":
            models.setdefault(row["model"], []).append(row)
    middle = [sorted(rows, key=_size)[len(rows) // 2] for rows in models.values()]
    return tuple(Source(SCENE, {"case": row["case"]}) for row in middle)


def _size(row: dict[str, str]) -> int:
    return 3 * int(row["contacts"]) + int(row["limits"]) + int(row["dry_friction"])


def kept(name: str) -> Array | None:
    """The array (nc, 3) of this name in robots.npz; None where there is none."""
    with np.load(ARRAYS, allow_pickle=False) as arrays:
        return arrays.get(name)
