"""What a run stores beside its tables, as JSON.

    DIR/convergence.json    convergence histories of solvers on a few problems
    DIR/shrunk              failing problems reduced in size: SOLVER-VERDICT-N-contacts-HASH.npz holds each of them, index.json
                            the result for each row

The readers return an empty value where nothing was written, and raise ResultsError naming the file where it cannot be read.
"""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from frictionbench.results.files import read_parsed, record, subfolder, write_text

CONVERGENCE, SHRUNK = "convergence.json", "shrunk"


class ConvergenceHistory(NamedTuple):
    """One solver on one problem, stopped after increasing amounts of its own work (sweeps, iterations or pivots).

    parameters: of the scene, JSON. units: the limits on work, ascending. residuals: the verified residual of the answer at
    each limit. impulse: the impulses of the last answer, per contact (normal, tangential...), N s; empty where not stored.
    redundant: the Delassus matrix W is rank deficient, so that impulses are not unique.
    """

    scene: str
    parameters: str
    step: int | None
    variant: str
    contacts: int
    redundant: bool
    units: list[int]
    residuals: list[float]
    impulse: list[list[float]]


class Shrunk(NamedTuple):
    """The reduction of a failing row's problem. file: its name below DIR/shrunk, empty if the failure was not reproduced.

    contacts: of the problem in the file. trials: calls of the solver. whole: no contact can be removed without losing the
    failure; otherwise the reduction ran out of time.
    """

    file: str
    contacts: int
    trials: int
    whole: bool


def write_histories(folder: Path, found: Sequence[ConvergenceHistory]) -> None:
    write_text(folder / CONVERGENCE, json.dumps([history._asdict() for history in found]))


def read_histories(folder: Path) -> list[ConvergenceHistory]:
    return read_parsed(folder / CONVERGENCE, lambda rows: [convergence_history(row) for row in rows], [])


def convergence_history(row: Any) -> ConvergenceHistory:
    """The history with these fields. Errors: ValueError, TypeError, LookupError or OverflowError where it is none."""
    history = record(ConvergenceHistory, row)
    numbers = [*history.residuals, *(part for contact in history.impulse for part in contact)]
    if len(history.units) != len(history.residuals) or not all(map(math.isfinite, numbers)):
        raise ValueError(f"the history of {history.variant} on {history.scene} is incomplete")
    return history


def write_shrunk(folder: Path, found: Mapping[str, Shrunk]) -> None:
    """Write the reductions, given by the keys of their rows."""
    write_text(subfolder(folder, SHRUNK) / "index.json", json.dumps({key: one._asdict() for key, one in found.items()}))


def read_shrunk(folder: Path) -> dict[str, Shrunk]:
    """The reductions by the keys of their rows."""
    index = folder / SHRUNK / "index.json"
    return read_parsed(index, lambda found: {str(key): record(Shrunk, one) for key, one in found.items()}, {})
