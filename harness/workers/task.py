"""What goes to a worker and what comes back."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

LONGEST_REPLY = 256 * 2**20  # bytes


@dataclass(frozen=True)
class Task:
    """A call of function(*arguments) in a worker, whose value is sent back as JSON.

    name: for the screen. limit: seconds. owner: the solver from outside this repository that it runs, or empty.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float
    owner: str = ""


@dataclass(frozen=True)
class Outcome:
    """What a task returned; or how it died: `death` is "timeout" or "crashed", with the reason."""

    task: Task
    value: Any = None
    death: str | None = None
    reason: str = ""
