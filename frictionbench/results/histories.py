"""Convergence histories of solvers on a few problems, stored in DIR/convergence.json."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from frictionbench.results.files import read_parsed, record, write_text

CONVERGENCE = "convergence.json"


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


def write_histories(folder: Path, found: Sequence[ConvergenceHistory]) -> None:
    write_text(folder / CONVERGENCE, json.dumps([history._asdict() for history in found]))


def read_histories(folder: Path) -> list[ConvergenceHistory]:
    """The histories; none where none were written. Errors: ResultsError naming the file where it cannot be read."""
    return read_parsed(folder / CONVERGENCE, lambda rows: [convergence_history(row) for row in rows], [])


def convergence_history(row: Any) -> ConvergenceHistory:
    """The history with these fields. Errors: ValueError, TypeError, LookupError or OverflowError where it is none."""
    history = record(ConvergenceHistory, row)
    numbers = [*history.residuals, *(part for contact in history.impulse for part in contact)]
    if len(history.units) != len(history.residuals) or not all(map(math.isfinite, numbers)):
        raise ValueError(f"the history of {history.variant} on {history.scene} is incomplete")
    return history
