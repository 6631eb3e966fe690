"""The numbers of contacts, velocities and joint equations that the fields of a problem state by their shapes.

The fields must agree. Where they do not, the field that differs from most is named: of three coefficients mu for the two
contacts of N and T, mu is wrong.
"""

from collections import Counter
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems.check import InputError
from frictionbench.problems.rows import Rows

Shape = tuple[int | None, ...]

# The number that each axis of a field states, and the rows that a contact has of it in dimension d.
_AXES: dict[str, tuple[str, ...]] = {
    "normal": ("contacts", "velocities"),
    "tangent": ("contacts", "velocities"),
    "mass": ("velocities", "velocities"),
    "free_velocity": ("velocities",),
    "friction": ("contacts",),
    "bias": ("contacts",),
    "friction_bias": ("contacts",),
    "joints": ("joint equations", "velocities"),
    "joint_bias": ("joint equations",),
    "W": ("contacts", "contacts"),
    "q": ("contacts",),
}


class _Stated(NamedTuple):
    field: str
    shape: Shape
    number: float


def agree(d: int, fields: dict[str, Any], names: dict[str, str] | None = None) -> None:
    """Check that the fields of a problem of dimension d, or those of its Delassus form, state the same numbers.

    fields: as they were given; None for one that was not. What has a wrong number of axes states nothing; the check of the
    field itself refuses it. names: what an error calls the fields, where not as here.
    Errors: InputError naming the field that differs from most, with both numbers.
    """
    rows = {"tangent": d - 1, "W": d, "q": d}
    stated: dict[str, list[_Stated]] = {}
    for field, value in fields.items():
        shape, axes = _shape(value), _AXES[field]
        for size, number in zip(shape, axes, strict=True) if len(shape) == len(axes) else ():
            if size is not None:
                per_contact = rows.get(field, 1) if number == "contacts" else 1
                stated.setdefault(number, []).append(_Stated(field, shape, size / per_contact))
    for number, found in stated.items():
        counts = Counter(one.number for one in found)
        most = max(counts, key=lambda count: (count.is_integer(), counts[count]))  # the first stated, where none has most
        if len(counts) > 1 or not most.is_integer():
            wrong = next(one for one in found if one.number != most or not most.is_integer())
            raise _disagreement(number, wrong, [one.field for one in found if one.number == most], most, d, names or {})


def _disagreement(number: str, wrong: _Stated, others: list[str], most: float, d: int, names: dict[str, str]) -> InputError:
    agreeing = [names.get(field, field) for field in dict.fromkeys(others) if field != wrong.field]
    whole = float(wrong.number).is_integer()
    reason = f"states {wrong.number:g} {number}" if whole else f"states no whole number of {number}"
    reason += f" by its shape {wrong.shape}"
    if agreeing:
        reason += f", but {' and '.join(filter(None, (', '.join(agreeing[:-1]), agreeing[-1])))} {most:g}"
    if number == "contacts":
        reason += f"; {names.get('dimension', 'dimension')} is {d}"
    return InputError(f"{names.get(wrong.field, wrong.field)}: {reason}")


def _shape(value: Any) -> Shape:
    """The shape of a field, () where it has none; the columns of a matrix by rows are not known."""
    if isinstance(value, Rows):
        return len(value.start) - 1, None
    try:
        return np.shape(value)
    except ValueError:  # rows of unlike lengths
        return ()
