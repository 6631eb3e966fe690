"""Polyhedra given by vertices and rays, cut by one plane at a time, and the shape of their unions.

A polyhedron {x} is stored as the cone {(x, tau)} of its generators: those with tau > 0 are vertices x/tau, those with tau = 0
rays. A cut keeps the generators on one side and adds the points where edges cross the plane. Two generators span an edge if no
third is tight in all the inequalities in which both are tight. This is the double description method (Motzkin, Raiffa, Thompson
and Thrall 1953; Fukuda and Prodon 1996). It must start with a pointed cone and is meant for a few dozen generators.
"""

from collections.abc import Callable, Iterable, Iterator
from enum import Enum
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from frictionbench.problems.check import Array

SAME_POINT = 1e-7  # points at most this far apart, relative to 1 plus their size, count as equal


class Cone(NamedTuple):
    """generators: (k, n+1), largest entry 1. tight: (k, m), whether each inequality is an equality at each generator.

    tie: the distance from a plane (largest coefficient 1), also from tau = 0, up to which a generator counts as lying on it.
    """

    generators: Array
    tight: NDArray[np.bool_]
    tie: float


class Polyhedron(NamedTuple):
    """The points sum a_i vertices_i + sum b_j rays_j with a, b >= 0 and sum a = 1. vertices: (k, n), rays: (j, n).

    mode: a label that distinguishes the pieces of a union.
    """

    vertices: Array
    rays: Array
    mode: str = ""

    @property
    def dimension(self) -> int:
        """0 for a point, 1 for a segment or ray, ..."""
        spread = np.vstack([self.vertices[1:] - self.vertices[0], self.rays])
        size = 1.0 + np.abs(self.vertices).max(initial=0.0)
        return int(np.linalg.matrix_rank(spread, tol=SAME_POINT * size)) if spread.size else 0


class Shape(Enum):
    """The shape of a union of polyhedra."""

    NONE = "none"
    ONE = "one"
    CONVEX = "convex"
    ISOLATED = "isolated"
    NOT_CONVEX = "not convex"


def simplicial(facets: Array, tie: float) -> Cone:
    """The cone {x : facets x >= 0} of n independent facets."""
    generators = np.asarray(np.linalg.inv(facets).T, dtype=np.float64)
    return Cone(_unit(generators), ~np.eye(len(facets), dtype=bool), tie)


def cut(cone: Cone, row: Array, equality: bool) -> Cone:
    """The part of the cone with row'x >= 0, or with row'x = 0."""
    generators, tight, tie = cone
    value = generators @ (row / (np.abs(row).max() or 1.0))
    value[np.abs(value) <= tie] = 0.0
    keep = value == 0 if equality else value >= 0
    above, below = np.flatnonzero(value > 0), np.flatnonzero(value < 0)
    crossing, both = np.zeros((0, generators.shape[1])), np.zeros((0, tight.shape[1]), dtype=bool)
    if len(above) and len(below):
        p, m = (side.ravel() for side in np.meshgrid(above, below, indexing="ij"))
        both = tight[p] & tight[m]
        not_tight = both.astype(np.float32) @ ~tight.T  # how many of these inequalities are not tight at each generator
        edge = np.count_nonzero(not_tight == 0, axis=1) == 2
        p, m, both = p[edge], m[edge], both[edge]
        crossing = _unit(value[p, None] * generators[m] - value[m, None] * generators[p])
    tight = np.vstack([tight[keep], both])
    if not equality:
        tight = np.column_stack([tight, np.concatenate([value[keep] == 0, np.ones(len(both), dtype=bool)])])
    return Cone(np.vstack([generators[keep], crossing]), tight, tie)


def polyhedron(cone: Cone, mode: str) -> Polyhedron | None:
    """The points x with (x, 1) in the cone, None if there are none."""
    x, tau = cone.generators[:, :-1], cone.generators[:, -1]
    finite = tau > cone.tie
    if not finite.any():
        return None
    return Polyhedron(x[finite] / tau[finite, None], x[~finite], mode)


def distinct(points: Array) -> Array:
    """The points (k, n) without repetitions."""
    return points[[i for i in range(len(points)) if not _among(points[i : i + 1], points[:i])]]


def maximal(pieces: Iterable[Polyhedron], within: Callable[[Polyhedron, Polyhedron], bool]) -> list[Polyhedron]:
    """The pieces that do not lie in another; of equal ones, the first."""
    pieces_kept: list[Polyhedron] = []
    for piece in pieces:
        if not any(within(piece, other) for other in pieces_kept):
            pieces_kept = [other for other in pieces_kept if not within(other, piece)] + [piece]
    return pieces_kept


def is_face(piece: Polyhedron, other: Polyhedron) -> bool:
    """Whether all generators of the piece are generators of the other: inclusion, if the two meet in a common face."""
    return _among(piece.vertices, other.vertices) and _among(piece.rays, other.rays)


def is_subset(piece: Polyhedron, other: Polyhedron) -> bool:
    """Whether the piece lies in the other, by linear programming."""
    directions = Polyhedron(np.zeros_like(other.vertices[:1]), other.rays)
    return all(contains(other, x) for x in piece.vertices) and all(contains(directions, x) for x in piece.rays)


def contains(piece: Polyhedron, x: Array) -> bool:
    """Whether x is in the polyhedron: its distance in the maximum norm, by a linear program, is up to SAME_POINT (1 + |x|)."""
    size = SAME_POINT * (1.0 + np.abs(x).max())
    if len(piece.vertices) == 1 and not len(piece.rays):
        return bool(np.abs(piece.vertices[0] - x).max() <= size)
    (k, n), j = piece.vertices.shape, len(piece.rays)
    combined = np.vstack([piece.vertices, piece.rays]).T
    slack = np.ones((n, 1))
    result = linprog(
        np.concatenate([np.zeros(k + j), [1.0]]),
        A_ub=np.block([[combined, -slack], [-combined, -slack]]),
        b_ub=np.concatenate([x, -x]),
        A_eq=np.concatenate([np.ones(k), np.zeros(j + 1)])[None],
        b_eq=[1.0],
    )
    return bool(result.status == 0 and result.fun <= size)


def shape(pieces: list[Polyhedron], is_solution: Callable[[Array], bool]) -> Shape:
    """The shape of the union of maximal pieces, which is not convex if the midpoint of two of its points is outside.

    Pairs of vertices, of points on rays and of centres are tried. If no such pair is found, the union is called convex, which
    is not a proof.
    """
    if not pieces:
        return Shape.NONE
    points_only = all(piece.dimension == 0 for piece in pieces)
    for a, b in combinations(pieces, 2):
        for x, y in product(samples(a), samples(b)):
            if not is_solution((x + y) / 2):
                return Shape.ISOLATED if points_only else Shape.NOT_CONVEX
    return Shape.ONE if points_only else Shape.CONVEX


def samples(piece: Polyhedron) -> Iterator[Array]:
    """A point inside, all vertices, and a point along every ray."""
    centre, size = piece.vertices.mean(axis=0), 1.0 + np.abs(piece.vertices).max(initial=0.0)
    yield centre + size * piece.rays.sum(axis=0)
    yield from piece.vertices
    yield from centre + size * piece.rays


def _among(points: Array, others: Array) -> bool:
    if not len(points):
        return True
    if not len(others):
        return False
    apart = np.abs(points[:, None] - others[None]).max(axis=2, initial=0.0)
    return bool(np.all(apart.min(axis=1) <= SAME_POINT * (1.0 + np.abs(points).max(axis=1, initial=0.0))))


def _unit(rows: Array) -> Array:
    return rows / np.abs(rows).max(axis=1, keepdims=True) if len(rows) else rows
