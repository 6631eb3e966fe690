"""Convergence histories of solvers on a few problems, stored in DIR/convergence.json."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field, FiniteFloat

from frictionbench.results.files import read_parsed, write_text

CONVERGENCE = "convergence.json"
Count = Annotated[int, Field(ge=0, le=10**9)]  # far above what a history counts: a larger one cannot be drawn


@dataclass(frozen=True)
class ConvergenceHistory:
    """One solver on one problem, stopped after increasing amounts of its own work (sweeps, iterations or pivots).

    parameters: of the scene, JSON. units: the limits on work, ascending. residuals: the verified residual of the answer at
    each limit.
    """

    scene: str
    parameters: str
    step: int | None
    variant: str
    contacts: Count
    units: list[Count]
    residuals: list[FiniteFloat]

    def __post_init__(self) -> None:
        if len(self.units) != len(self.residuals):
            raise ValueError(f"the history of {self.variant} on {self.scene} is incomplete")


def write_histories(folder: Path, histories: Sequence[ConvergenceHistory]) -> None:
    write_text(folder / CONVERGENCE, json.dumps([asdict(history) for history in histories]))


def read_histories(folder: Path) -> list[ConvergenceHistory]:
    """Read the histories; none if none were written. Errors: ResultsError naming the file if it cannot be read."""
    return read_parsed(folder / CONVERGENCE, list[ConvergenceHistory], [])
