"""What is sent to a worker and what it returns."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from frictionbench.problems import InputError
from frictionbench.problems.verdicts import Verdict

# Bytes: far above the longest row, which has a simulation's curves. It bounds the memory of the main process.
LONGEST_REPLY = 256 * 2**20


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

    def input_error(self, otherwise: str) -> InputError:
        """The failure as an error: its reason where that begins with the name of a field, else the message `otherwise`."""
        return InputError(self.reason if self.reason.startswith(("solver: ", "scheme: ")) else otherwise)
