"""The answer of a solver, and the check of its format: a copy as plain arrays and numbers, or an error naming the field."""

import math
import operator
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from frictionbench.problems.check import Array

LONGEST_MESSAGE = 500  # characters kept of a solver's own message: a few lines in a table


class Status(Enum):
    """How a solver reports that it ended; the values are messages. The status is a claim: `verify` checks the answer.

    >>> import frictionbench as fb
    >>> fb.Status.STALLED.value
    'no further progress was possible'
    """

    SOLVED = "solved to the requested tolerance"
    RAY = "ended on a secondary ray with a valid certificate: this path leads to no solution"
    INFEASIBLE = "no impulses reach the tolerance: contacts or joints that contradict each other prove it"
    WORK_LIMIT = "reached the work limit"
    STALLED = "no further progress was possible"
    BREAKDOWN = "numerical breakdown"
    TIME_LIMIT = "reached the time limit: this is the best answer found until then"
    ROUNDING = "solved as far as can be told: rounding alone may leave a residual above the requested tolerance"
    FAILED = "the outside library reported a failure"


@dataclass(eq=False, slots=True, repr=False)
class Answer:
    """The result of a solver. As an array it is its impulse, so that it can be a start or be given to `residual`.

    impulse: (nc, d), N s, the normal component first; (0, 0) for a bare LCP. z: (n,), the solution of the LCP, for LCP solvers.
    status: how the solver reports that it ended.
    work: deterministic counts by name (pivots, sweeps, iterations, factorisations).
    history: the method's own measure of convergence, one number per iteration; empty if it has none.
    detail: the message of the outside library, or the reason of the status.
    clock: s, the solve time that the library reports itself, if any; the harness times the whole call as well.
    softness: (nc, d), 1/kg, for solvers of regularised contacts: the R >= 0 in u = W r + q + R r; problems.verify bounds it.
    solver: the name under which frictionbench.solve called the solver; "" if the solver was called directly.

    >>> import frictionbench as fb
    >>> answer = fb.solve(fb.scene("stack", blocks=2).problem(), "lemke")
    >>> answer.impulse.shape, answer.status.name, sorted(answer.work)[-1]
    ((4, 2), 'SOLVED', 'restarts')
    """

    impulse: Array
    status: Status
    work: dict[str, int] = field(default_factory=dict)
    history: tuple[float, ...] = ()
    z: Array | None = None
    detail: str = ""
    clock: float | None = None
    softness: Array | None = None
    solver: str = ""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.impulse, dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        status = getattr(self.status, "name", repr(self.status)) + (f" by {self.solver}" if self.solver else "")
        arrays = [f"{name} {np.shape(array)}" for name in ("impulse", "z") if (array := getattr(self, name)) is not None]
        return f"Answer({', '.join([status, *arrays, *(f'{unit} {count}' for unit, count in self.work.items())])})"


class AnswerError(ValueError):
    """A malformed answer; the message names the field. claimed: whether its status is SOLVED."""

    def __init__(self, reason: str, claimed: bool) -> None:
        super().__init__(reason)
        self.claimed = claimed


def checked_copy(returned: Any) -> Answer:
    """A copy of an answer. Errors: AnswerError."""
    if not isinstance(returned, Answer):
        raise AnswerError(f"the solver returned {_kind(returned)}, not an Answer", claimed=True)
    if not isinstance(returned.status, Status):
        raise AnswerError(f"status is {_kind(returned.status)}, not a Status", claimed=True)
    claimed = returned.status is Status.SOLVED
    return Answer(
        impulse=_numbers("impulse", returned.impulse, claimed),
        status=returned.status,
        work=_counts(returned.work, claimed),
        z=None if returned.z is None else _numbers("z", returned.z, claimed),
        detail=str(returned.detail)[:LONGEST_MESSAGE],
        clock=returned.clock if isinstance(returned.clock, float) and 0 <= returned.clock < math.inf else None,
        softness=None if returned.softness is None else _numbers("softness", returned.softness, claimed),
    )


def is_plain(answer: Any) -> bool:
    """Whether an answer has only numpy arrays and Python's or numpy's integers and text, so that reading it runs no code."""
    if type(answer) is not Answer or type(answer.work) is not dict or type(answer.detail) is not str:
        return False
    arrays = (answer.impulse, answer.z, answer.softness)
    return all(array is None or type(array) is np.ndarray for array in arrays) and all(
        type(count) in (int, np.int64) for count in answer.work.values()
    )


def bits(answer: Answer) -> tuple[Any, ...]:
    """All bits of a checked answer, work counters included, by which two answers are compared."""
    z, softness = (None if part is None else part.tobytes() for part in (answer.z, answer.softness))
    return answer.status, answer.impulse.shape, answer.impulse.tobytes(), z, softness, answer.work


def _numbers(field: str, value: Any, claimed: bool) -> Array:
    if isinstance(value, np.ma.MaskedArray):
        raise AnswerError(f"{field} is a masked array", claimed)
    try:
        array = np.array(value)
    except Exception as error:
        raise AnswerError(f"{field} is {_kind(value)}, not an array ({type(error).__name__})", claimed) from None
    if array.dtype.kind not in "fiu":
        raise AnswerError(f"{field} is an array of {array.dtype}, not of real numbers", claimed)
    return array.astype(np.float64)


def _counts(work: Any, claimed: bool) -> dict[str, int]:
    if not isinstance(work, dict):
        raise AnswerError(f"work is {_kind(work)}, not a dict", claimed)
    counts = {}
    for name, count in work.items():
        try:
            counts[str(name)[:LONGEST_MESSAGE]] = operator.index(count)
        except TypeError:
            raise AnswerError(f"work[{name!r}] is {_kind(count)}, not a whole number", claimed) from None
    return counts


def _kind(value: Any) -> str:
    return "None" if value is None else f"an object of type {type(value).__name__}"
