"""Contact finding between convex planar shapes.

A contact is between a corner of one shape and an edge of another; this pair is its `feature`. The gap is measured along the
edge's normal, and the arms of both bodies end at the corner, so that the gap's gradient is exactly the contact's normal row.
This module is the broad phase, which finds pairs of nearby shapes; problems.planar.narrow_phase computes their contacts.
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.planar.bodies import Geometry
from frictionbench.problems.planar.narrow_phase import meet
from frictionbench.problems.rows import Index64, Rows, planar_relative


@dataclass(frozen=True, eq=False)
class Contacts:
    """nc contacts, in the order of their shapes.

    gap: (nc,), m, positive if separated. place: (nc, 2 d), the point, in the plane a corner, and the unit normal, from the
    second body to the first. bodies: (nc, 2), -1 for the ground. feature: (nc, 2), the corner and the edge (its first corner)
    that meet; the same contact has the same feature in all steps. q: the bodies' coordinates.
    """

    gap: Array
    place: Array
    bodies: Index64
    feature: Index64
    q: Array

    def __len__(self) -> int:
        return len(self.gap)

    @property
    def point(self) -> Array:
        return self.place[:, : self.place.shape[1] // 2]

    @property
    def direction(self) -> Array:
        return self.place[:, self.place.shape[1] // 2 :]

    @property
    def velocities(self) -> int:
        """nv."""
        return len(self.q)

    @cached_property
    def normal_rows(self) -> Rows:
        """(nc, nv), the relative velocity of the bodies at the point along the normal."""
        return self._rows(self.direction[:, None])

    @cached_property
    def tangent_rows(self) -> Rows:
        """(nc*(d-1), nv), the relative velocity along the tangents."""
        return self._rows(self.tangents)

    @property
    def tangents(self) -> Array:
        """(nc, d - 1, d); in the plane, the normal rotated by -90 degrees."""
        return (self.direction[:, ::-1] * [1.0, -1.0])[:, None]

    def _rows(self, along: Array) -> Rows:
        """The relative velocity along one direction of each contact (nc, 1, d), or along its tangents."""
        arms = self.point[:, None] - self.q.reshape(-1, 3)[self.bodies, :2]
        return planar_relative(self.bodies, arms, along[:, 0])

    @cached_property
    def normal(self) -> sparse.csr_array:
        return self.normal_rows.matrix(self.velocities)

    @cached_property
    def tangent(self) -> sparse.csr_array:
        return self.tangent_rows.matrix(self.velocities)

    def only(self, chosen: NDArray[np.bool_] | Index64) -> Self:
        """The contacts for which `chosen` (nc,) is true, or those with these indices."""
        return replace(self, **{each.name: getattr(self, each.name)[chosen] for each in fields(self) if each.name != "q"})


def find_contacts(geometry: Geometry, q: Array, margin: float) -> Contacts:
    """All contacts with gap <= margin (m) at the coordinates q (nv,)."""
    q = check.vector("q", q)
    corners = geometry.world_corners(q)
    start, owner, radius, endless = geometry.start, geometry.owner, geometry.radius, geometry.endless
    low = np.where(endless[:, None], -np.inf, _reduce(np.minimum, corners, start) - radius[:, None])
    high = np.where(endless[:, None], np.inf, _reduce(np.maximum, corners, start) + radius[:, None])
    beyond = (low[:, None] > high + margin).any(axis=2)
    # Pairs (i < j) of shapes of different bodies whose bounding boxes [low, high] are within the margin, in order.
    pairs = np.argwhere(np.triu(~(beyond | beyond.T) & (owner[:, None] != owner)))
    gap, place, feature, shape = meet(pairs[~geometry.hinged(pairs)], corners, start, radius, endless, margin)
    return Contacts(gap, place, owner[shape], feature, q)


def _reduce(extreme: np.ufunc, corners: Array, start: Index64) -> Array:
    return np.asarray(extreme.reduceat(corners, start[:-1])) if len(start) > 1 else np.zeros((0, 2))
