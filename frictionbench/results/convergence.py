"""Convergence histories of solvers on a few problems of a run, stored in DIR/convergence.json."""

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

from frictionbench.results.files import ResultsError, read_json, write_text

NAME = "convergence.json"


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


def write_histories(folder: Path, found: list[ConvergenceHistory]) -> None:
    write_text(folder / NAME, json.dumps([history._asdict() for history in found]))


def read_histories(folder: Path) -> list[ConvergenceHistory]:
    """The histories; empty if none were written. Errors: ResultsError if the file cannot be read."""
    path = folder / NAME
    if not path.exists():
        return []
    rows = read_json(path)
    try:
        return [checked(row) for row in rows]
    except (ValueError, TypeError, LookupError, OverflowError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None


def checked(row: Any) -> ConvergenceHistory:
    """The history with these fields. Errors: ValueError, TypeError, LookupError or OverflowError where it is none."""
    history = ConvergenceHistory(
        str(row["scene"]),
        str(row["parameters"]),
        None if row["step"] is None else int(row["step"]),
        str(row["variant"]),
        int(row["contacts"]),
        bool(row["redundant"]),
        [int(count) for count in row["units"]],
        [float(value) for value in row["residuals"]],
        [[float(part) for part in contact] for contact in row["impulse"]],
    )
    numbers = [*history.residuals, *(part for contact in history.impulse for part in contact)]
    if len(history.units) != len(history.residuals) or not all(map(math.isfinite, numbers)):
        raise ValueError(f"the history of {history.variant} on {history.scene} is incomplete")
    return history
