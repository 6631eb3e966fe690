"""Contact finding between convex planar shapes.

Every contact is a corner of one shape against an edge of another, the pair `feature`, with its gap measured along the edge's
normal, so that the gap's gradient is exactly the contact's normal row: both bodies' arms end at the corner. Pairs of shapes
that are near each other are found here, where they meet in problems.planar.narrow_phase.
"""

from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse

from problems.check import Array
from problems.planar.bodies import Geometry
from problems.planar.narrow_phase import Index, meet


@dataclass(frozen=True, eq=False)
class Contacts:
    """nc contacts, in the order of their shapes.

    gap: (nc,), m, positive where separated. point: (nc, 2), the corner's place. direction: (nc, 2), the unit normal, from the
    second body to the first. bodies: (nc, 2), -1 for the ground. feature: (nc, 2), the corner and the edge (by its first
    corner) that meet: the same contact in two steps has the same feature. normal, tangent: (nc, nv), the relative velocity of
    the bodies at the point along the normal, and along the normal turned by -90 degrees.
    """

    gap: Array
    point: Array
    direction: Array
    bodies: Index
    feature: Index
    normal: sparse.csr_array
    tangent: sparse.csr_array

    def __len__(self) -> int:
        return len(self.gap)

    def only(self, chosen: NDArray[np.bool_]) -> Self:
        """The contacts where `chosen` (nc,) is true."""
        return type(self)(*(getattr(self, entry.name)[chosen] for entry in fields(self)))


def find_contacts(geometry: Geometry, q: Array, margin: float) -> Contacts:
    """All contacts with gap <= margin (m) at the coordinates q (nv,)."""
    gap, place, feature, shape = _meet(geometry, q, margin)
    point, direction = place[:, :2], place[:, 2:]
    bodies = geometry.owner[shape]
    turned = np.column_stack([direction[:, 1], -direction[:, 0]])
    return Contacts(gap, point, direction, bodies, feature, _rows(q, bodies, point, direction), _rows(q, bodies, point, turned))


def deepest_overlap(geometry: Geometry, q: Array) -> float:
    """The deepest overlap (m) of two shapes at the coordinates q (nv,); 0 where none overlap."""
    gap, *_ = _meet(geometry, q, 0.0)
    return float(max(0.0, -gap.min(initial=0.0)))


def _meet(geometry: Geometry, q: Array, margin: float) -> tuple[Array, Array, Index, Index]:
    corners = geometry.placed(q)
    start, owner, radius, endless = geometry.start, geometry.owner, geometry.radius, geometry.endless
    low = np.where(endless[:, None], -np.inf, _reduce(np.minimum, corners, start) - radius[:, None])
    high = np.where(endless[:, None], np.inf, _reduce(np.maximum, corners, start) + radius[:, None])
    pairs = near_pairs(low, high, owner, margin)
    return meet(pairs[~geometry.hinged(pairs)], corners, start, radius, endless, margin)


def _reduce(extreme: np.ufunc, corners: Array, start: Index) -> Array:
    return np.asarray(extreme.reduceat(corners, start[:-1])) if len(start) > 1 else np.zeros((0, 2))


def _rows(q: Array, bodies: Index, point: Array, axis: Array) -> sparse.csr_array:
    """Rows (nc, nv) of the velocity of the first body at the point relative to the second's, along the axis."""
    contact, side = np.nonzero(bodies >= 0)
    body = bodies[contact, side]
    sign = np.where(side == 0, 1.0, -1.0)
    arm = point[contact] - q.reshape(-1, 3)[body, :2]
    e = axis[contact]
    entries = sign[:, None] * np.column_stack([e, arm[:, 0] * e[:, 1] - arm[:, 1] * e[:, 0]])
    columns = 3 * body[:, None] + np.arange(3)
    triplets = (entries.ravel(), (np.repeat(contact, 3), columns.ravel()))
    return sparse.csr_array(sparse.coo_array(triplets, shape=(len(bodies), len(q))))


def near_pairs(low: Array, high: Array, owner: Index, margin: float) -> Index:
    """Pairs (i < j) of shapes of different bodies whose boxes [low, high] come within the margin, in order: a sweep along
    the axis on which the shapes are spread out more."""
    if not len(owner):
        return np.zeros((0, 2), dtype=np.int64)
    bounded = np.isfinite(low[:, 0])
    middle = (low[bounded] + high[bounded]) / 2
    axis = int(np.argmax(np.ptp(middle, axis=0))) if len(middle) else 0
    pairs = _sweep(np.argsort(low[:, axis], kind="stable"), low, high, owner, axis, margin)
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


@njit(cache=True, no_cfunc_wrapper=True)
def _sweep(order: Index, low: Array, high: Array, owner: Index, axis: int, margin: float) -> Index:
    found = []
    for k in range(len(order)):
        i = order[k]
        for m in range(k + 1, len(order)):
            j = order[m]
            if low[j, axis] > high[i, axis] + margin:
                break
            across = 1 - axis
            if (
                owner[i] != owner[j]
                and low[i, across] <= high[j, across] + margin
                and low[j, across] <= high[i, across] + margin
            ):
                found.append((min(i, j), max(i, j)))
    pairs = np.empty((len(found), 2), dtype=np.int64)
    for k, (i, j) in enumerate(found):
        pairs[k, 0], pairs[k, 1] = i, j
    return pairs
