"""The numbers of contacts, velocities and joint equations that the fields of a problem state by their shapes.

The fields must agree. Where they do not, the field that differs from most is named: of three coefficients mu for the two
contacts of N and T, mu is wrong.
"""

from collections import Counter
from typing import Any

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
    "bias": ("contacts",),
    "joints": ("joint equations", "velocities"),
    "joint_bias": ("joint equations",),
    "W": ("contacts", "contacts"),
    "q": ("contacts",),
    "friction": ("contacts",),
    "friction_bias": ("contacts",),
}


def agree(d: int, fields: dict[str, Any], names: dict[str, str] | None = None) -> None:
    """Check that the fields of a problem of dimension d, or those of its Delassus form, state the same numbers.

    fields: as they were given, by name, perhaps among others. What has a wrong number of axes states nothing; the check of the
    field itself refuses it. names: what an error calls the fields, where not as here.
    Errors: InputError naming the field that differs from most, with both numbers.
    """
    rows, named = {"tangent": d - 1, "W": d, "q": d}, names or {}
    stated: dict[str, list[tuple[str, Shape, float]]] = {}
    for field, axes in _AXES.items():
        shape = _shape(fields.get(field))
        for size, number in zip(shape, axes, strict=True) if len(shape) == len(axes) else ():
            if size is not None:
                per_contact = rows.get(field, 1) if number == "contacts" else 1
                stated.setdefault(number, []).append((field, shape, size / per_contact))
    for number, found in stated.items():
        counts = Counter(one for _, _, one in found)
        most = max(counts, key=lambda count: (count.is_integer(), counts[count]))  # the first stated, where none has most
        for field, shape, one in found:
            if one != most or not most.is_integer():
                agreeing = dict.fromkeys(named.get(other, other) for other, _, same in found if same == most and other != field)
                reason = f"states {f'{one:g}' if one.is_integer() else 'no whole number of'} {number} by its shape {shape}"
                reason += f", but {', '.join(agreeing)} {most:g}" if agreeing else ""
                reason += f"; {named.get('dimension', 'dimension')} is {d}" if number == "contacts" else ""
                raise InputError(f"{named.get(field, field)}: {reason}")


def _shape(value: Any) -> Shape:
    """The shape of a field, () where it has none; the columns of a matrix by rows are not known."""
    if isinstance(value, Rows):
        return len(value.start) - 1, None
    try:
        return np.shape(value)
    except ValueError:  # rows of unlike lengths
        return ()
