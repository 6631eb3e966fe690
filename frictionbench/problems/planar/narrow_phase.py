"""The contacts of two convex planar shapes: the kernels of problems.planar.collision.

Two polygons have contacts along the axis of largest separation or least overlap (separating axis theorem). The edge with this
axis as its normal is the reference edge. The most antiparallel edge of the other shape is clipped to it, and each end of the
clipped edge is a contact. Two shapes have at most two contacts, and none if they face each other corner to corner. A disc is a
corner with a radius; a hollow has a negative radius.

Ties (equal boxes stacked flush, bricks side by side) are decided by order and not by rounding: a candidate replaces an earlier
one only if it is better by more than TIE times the length of the first shape's first edge, and corners that only touch each
other have no contact.
"""

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.rows import Index64

TIE = 1e-7  # of a body's size, or of a cosine: far above the rounding errors of coordinates, far below any relevant gap


@kernel
def meet(
    pairs: Index64, X: Array, start: Index64, radius: Array, endless: NDArray[np.bool_], margin: float
) -> tuple[Array, Array, Index64, Index64]:
    """Contacts of the given pairs of shapes: gap (nc,), point and normal (nc, 4), feature (nc, 2), shapes (nc, 2)."""
    gap, place = np.empty(2 * len(pairs)), np.empty((2 * len(pairs), 4))
    feature, shape = np.empty((2 * len(pairs), 2), dtype=np.int64), np.empty((2 * len(pairs), 2), dtype=np.int64)
    nc = 0
    for p in range(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        i0, i1, j0, j1 = start[i], start[i + 1], start[j], start[j + 1]
        new = 0
        if i1 - i0 == 1 or j1 - j0 == 1:
            new = _round(X, i0, i1, j0, j1, radius[i], radius[j], endless[j], gap[nc:], place[nc:], feature[nc:])
        else:
            new = _polygons(X, i0, i1, j0, j1, endless[j], margin, gap[nc:], place[nc:], feature[nc:])
        for k in range(nc, nc + new):
            if gap[k] <= margin:
                gap[nc], shape[nc, 0], shape[nc, 1] = gap[k], i, j
                feature[nc, 0], feature[nc, 1] = feature[k, 0], feature[k, 1]
                for a in range(4):  # by entries: assigning rows would also compile the error for unequal lengths
                    place[nc, a] = place[k, a]
                nc += 1
    return gap[:nc], place[:nc], feature[:nc], shape[:nc]


@part
def _edge(X: Array, e: int, first: int, last: int) -> tuple[int, float, float, float]:
    """The end of edge e of a shape with corners first..last-1, its outward unit normal, and its length."""
    f = e + 1 if e + 1 < last else first
    dx, dy = X[f, 0] - X[e, 0], X[f, 1] - X[e, 1]
    length = np.hypot(dx, dy)
    return f, dy / length, -dx / length, length


@part
def _widest(X: Array, a0: int, a1: int, b0: int, b1: int, edges: int, tie: float) -> tuple[int, float]:
    """The edge among A's first `edges` with the largest separation from B, and this separation."""
    best, widest = a0, -np.inf
    for e in range(a0, a0 + edges):
        _, nx, ny, _ = _edge(X, e, a0, a1)
        depth = np.inf
        for k in range(b0, b1):
            depth = min(depth, nx * (X[k, 0] - X[e, 0]) + ny * (X[k, 1] - X[e, 1]))
        if depth > widest + tie:
            best, widest = e, depth
    return best, widest


@part
def _polygons(
    X: Array, i0: int, i1: int, j0: int, j1: int, endless: bool, margin: float, gap: Array, place: Array, feature: Index64
) -> int:
    """Contacts of polygon i with polygon or half plane j; returns the number of contacts written."""
    tie = TIE * np.hypot(X[i0, 0] - X[i0 + 1, 0], X[i0, 1] - X[i0 + 1, 1])
    reference, depth = _widest(X, j0, j1, i0, i1, 1 if endless else j1 - j0, tie)
    a0, a1, b0, b1, sign = j0, j1, i0, i1, 1.0
    if not endless:
        other, other_depth = _widest(X, i0, i1, j0, j1, i1 - i0, tie)
        if other_depth > depth + tie:
            reference, depth = other, other_depth
            a0, a1, b0, b1, sign = i0, i1, j0, j1, -1.0
    if depth > margin:
        return 0
    end, nx, ny, length = _edge(X, reference, a0, a1)
    incident, opposed = b0, np.inf
    for e in range(b0, b1):
        _, mx, my, _ = _edge(X, e, b0, b1)
        if mx * nx + my * ny < opposed - TIE:
            incident, opposed = e, mx * nx + my * ny
    low, mx, my, incident_length = _edge(X, incident, b0, b1)  # opposite in direction to the reference edge
    high = incident
    s_low = -ny * (X[low, 0] - X[reference, 0]) + nx * (X[low, 1] - X[reference, 1])
    s_high = -ny * (X[high, 0] - X[reference, 0]) + nx * (X[high, 1] - X[reference, 1])
    if s_low > s_high:
        low, high, s_low, s_high = high, low, s_high, s_low
    overlap = min(s_high, length) - max(s_low, 0.0)
    if not endless and overlap <= tie and (overlap < -tie or s_high - s_low > tie):
        return 0  # the edges do not overlap: side by side, or corner to corner
    new = 0
    for corner, inside, limit in (
        (low, endless or s_low >= -tie, reference),
        (high, endless or s_high <= length + tie, end),
    ):
        if inside:  # the incident corner meets the reference edge
            c, e, x, y, reach = corner, reference, nx, ny, margin
        else:  # the reference corner meets the incident edge, within the margin along the reference normal
            c, e, x, y, reach = limit, incident, mx, my, -margin * opposed
        dx, dy = X[c, 0] - X[e, 0], X[c, 1] - X[e, 1]
        distance, along = x * dx + y * dy, x * dy - y * dx
        aside = not inside and distance > 0 and (along < -tie or along > incident_length + tie)
        if distance <= reach and not aside:
            side = sign if inside else -sign
            gap[new] = distance
            place[new, 0], place[new, 1], place[new, 2], place[new, 3] = X[c, 0], X[c, 1], side * x, side * y
            feature[new, 0], feature[new, 1] = c, e
            new += 1
    return new


@part
def _round(
    X: Array,
    i0: int,
    i1: int,
    j0: int,
    j1: int,
    ri: float,
    rj: float,
    endless: bool,
    gap: Array,
    place: Array,
    feature: Index64,
) -> int:
    """The contact of a disc with a disc, a polygon, a half plane or a hollow; returns the number of contacts written, 1."""
    c, a0, a1, sign = i0, j0, j1, 1.0
    if i1 - i0 > 1:
        c, a0, a1, sign = j0, i0, i1, -1.0
    r, other = (ri, rj) if sign > 0 else (rj, ri)
    nearest, nx, ny, distance = a0, 0.0, 0.0, 0.0
    beyond = a1 - a0 == 1
    if not beyond:
        nearest, distance = _widest(X, a0, a1, c, c + 1, 1 if endless else a1 - a0, 0.0)
        end, nx, ny, length = _edge(X, nearest, a0, a1)
        s = -ny * (X[c, 0] - X[nearest, 0]) + nx * (X[c, 1] - X[nearest, 1])
        beyond = not endless and distance > 0 and (s < 0 or s > length)
        if beyond and s > length:
            nearest = end
    if beyond:  # the nearest point is a corner, or the other disc's centre
        nx, ny = X[c, 0] - X[nearest, 0], X[c, 1] - X[nearest, 1]
        distance = np.hypot(nx, ny)
        nx, ny = (nx / distance, ny / distance) if distance > 0 else (0.0, 1.0)
        if other < 0:  # a hollow: the gap is measured inwards from its circle
            nx, ny, distance = -nx, -ny, -distance
    gap[0] = distance - r - other
    place[0, 0], place[0, 1] = X[c, 0] - r * nx, X[c, 1] - r * ny
    place[0, 2], place[0, 3] = sign * nx, sign * ny
    feature[0, 0], feature[0, 1] = c, nearest
    return 1
