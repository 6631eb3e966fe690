"""Checking what a solver returns: a copy as plain arrays and numbers, or an error that names the malformed field."""

import math
import operator
from typing import Any

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.solvers import Answer, Status

LONGEST = 500  # characters of a solver's own message: a few lines of a table's reason


class AnswerError(ValueError):
    """A malformed answer (see solvers.interface); the message names the field. claimed: whether its status is SOLVED."""

    def __init__(self, reason: str, claimed: bool) -> None:
        super().__init__(reason)
        self.claimed = claimed


def checked_copy(given: Any) -> Answer:
    """A copy of an answer. Errors: AnswerError."""
    if not isinstance(given, Answer):
        raise AnswerError(f"the solver returned {_kind(given)}, not an Answer", claimed=True)
    if not isinstance(given.status, Status):
        raise AnswerError(f"status is {_kind(given.status)}, not a Status", claimed=True)
    claimed = given.status is Status.SOLVED
    return Answer(
        impulse=_numbers("impulse", given.impulse, claimed),
        status=given.status,
        work=_counts(given.work, claimed),
        z=None if given.z is None else _numbers("z", given.z, claimed),
        detail=str(given.detail)[:LONGEST],
        clock=given.clock if isinstance(given.clock, float) and 0 <= given.clock < math.inf else None,
        softness=None if given.softness is None else _numbers("softness", given.softness, claimed),
    )


def identical(one: Answer, other: Answer) -> bool:
    """Whether two checked answers are the same to the last bit, work counters included."""
    return _bits(one) == _bits(other)


def _bits(answer: Answer) -> tuple[Any, ...]:
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
            counts[str(name)[:LONGEST]] = operator.index(count)
        except TypeError:
            raise AnswerError(f"work[{name!r}] is {_kind(count)}, not a whole number", claimed) from None
    return counts


def _kind(value: Any) -> str:
    return "None" if value is None else f"of type {type(value).__name__}"
