"""The numbers of contacts, velocities and joint equations that follow from the shapes of a problem's fields.

The fields must agree. If they do not, the error names the field that differs from the majority: if mu has three coefficients
but N and T have two contacts, mu is wrong.
"""

from collections import Counter
from typing import Any

import numpy as np

from frictionbench.problems.check import InputError
from frictionbench.problems.rows import Rows

Shape = tuple[int | None, ...]

# The number to which each axis of a field refers.
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

    fields: as given, by name; other names are ignored. A field with a wrong number of axes is ignored too, because the check of
    the field itself refuses it. names: how an error calls a field or the dimension, if not by the name used here.
    Errors: InputError naming the field that differs from the majority, with both numbers.
    """
    rows, named = {"tangent": d - 1, "W": d, "q": d}, names or {}
    stated: dict[str, list[tuple[str, Shape, float]]] = {}
    for field, axes in _AXES.items():
        shape = _shape(fields.get(field))
        for size, number in zip(shape, axes, strict=True) if len(shape) == len(axes) else ():
            if size is not None:
                per_contact = rows.get(field, 1) if number == "contacts" else 1
                stated.setdefault(number, []).append((field, shape, size / per_contact))
    for number, uses in stated.items():
        counts = Counter(one for _, _, one in uses)
        most = max(counts, key=lambda count: (count.is_integer(), counts[count]))  # of equally frequent ones, the first
        for field, shape, one in uses:
            if one != most or not most.is_integer():
                agreeing = dict.fromkeys(named.get(other, other) for other, _, same in uses if same == most and other != field)
                reason = f"states {f'{one:g}' if one.is_integer() else 'no whole number of'} {number} by its shape {shape}"
                reason += f", but {', '.join(agreeing)} {most:g}" if agreeing and most.is_integer() else ""
                reason += f"; {named.get('dimension', 'dimension')} is {d}" if number == "contacts" else ""
                raise InputError(f"{named.get(field, field)}: {reason}")


def _shape(value: Any) -> Shape:
    """The shape of a field, () if it has none. The number of columns of Rows is unknown: None."""
    if isinstance(value, Rows):
        return len(value.start) - 1, None
    try:
        return np.shape(value)
    except ValueError:  # rows of different lengths
        return ()
