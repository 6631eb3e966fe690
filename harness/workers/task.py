"""What is sent to a worker and what it returns."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from frictionbench.results.verdicts import Verdict

LONGEST_REPLY = (
    256 * 2**20
)  # bytes: far above the longest row, a simulation's curves; a bound on the memory of the main process


@dataclass(frozen=True)
class Task:
    """A call of function(*arguments) in a worker, whose value is sent back as JSON.

    name: shown in the progress bar. limit: seconds. owner: the solver from outside this repository that it runs, or empty.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float
    owner: str = ""


@dataclass(frozen=True)
class Outcome:
    """What a task returned; or, where it returned nothing, the verdict (TIMEOUT or CRASHED) and the reason."""

    task: Task
    value: Any = None
    failure: Verdict | None = None
    reason: str = ""
