"""Proofs that a problem has no solution, because contacts and joint equations contradict each other.

The velocities after a step satisfy N v + b >= 0 and F v + b_F = 0, whatever the friction. By Farkas' lemma, no velocity does if
and only if there are weights y >= 0 and z of these conditions with

    N'y + F'z = 0,      b'y + b_F'z < 0.

A linear program proposes the weights. They are checked in rational arithmetic with the exact values of the floating-point data.
Let rho = N'y + F'z be the defect and g = -(b'y + b_F'z) > 0 the gain. A velocity that satisfies all conditions has rho'v >= g,
so that none exists if rho = 0, and none with |v| < g/|rho| otherwise.

The weighted sum y'u_n = rho'v - g of the velocities u_n = N v + b shows more: if rho = 0, some contact penetrates with at least
g/sum y, and no impulses have a residual below g/(y'unit).

If only W is known, N v + b is replaced by the normal rows of W r + q, and velocities by impulses. The condition is only
sufficient: with friction, a problem may have no solution although its conditions can be satisfied.
"""

from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array, require
from frictionbench.problems.forms.joints import CONTRADICTION, DEFECT_ROUNDING
from frictionbench.problems.friction import FrictionProblem

LEAST_WEIGHT = 1e-9  # relative to the largest weight: smaller ones are set to zero
FAR = 1e6  # times the problem's own velocities: a proof must exclude all velocities up to this


class Contradiction(NamedTuple):
    """Conditions that no velocity satisfies.

    y: (nc,) >= 0 and z: (nj,), the proved weights of contacts and joint equations. beyond: no velocity up to this multiple of
    the problem's own, the largest of v* and b scaled by masses, satisfies the conditions; infinite if rho = 0.
    least_residual: of all impulses that give velocities up to sqrt(beyond) times the problem's own.
    """

    y: Array
    z: Array
    beyond: float
    least_residual: float

    def __str__(self) -> str:
        named = [*_named("contact", self.y), *_named("joint equation", self.z)]
        reason = "no solution exists: the conditions of " + " and ".join(named) + " contradict each other"
        return f"{reason}; no impulses have a residual below {self.least_residual:.2g}"


def _named(what: str, weights: Array) -> Iterable[str]:
    found = np.flatnonzero(weights).tolist()
    if found:
        yield what + "s" * (len(found) > 1) + " " + ", ".join(map(str, found[:6])) + ", ..." * (len(found) > 6)


def contradiction(problem: FrictionProblem) -> Contradiction | None:
    """The proof that a problem has no solution, None if no proof of this kind is found.

    Errors: InputError naming problem if it is not a FrictionProblem.

    >>> import frictionbench as fb
    >>> walls = {"normal": [[1.0], [-1.0]], "tangent": [[0.0], [0.0]], "friction": [0.5, 0.5]}
    >>> problem = fb.FrictionProblem(mass=[[1.0]], free_velocity=[0.0], bias=[-1.0, -0.5], **walls)
    >>> fb.contradiction(problem).y  # both walls ask the body to retreat
    array([1., 1.])
    """
    require(isinstance(problem, FrictionProblem), "problem", "a FrictionProblem is needed")
    conditions, offset, own = _conditions(problem)
    nc = problem.contacts
    if not (offset[:nc] < 0).any() and not offset[nc:].any():
        return None  # v = 0 satisfies all
    row = _power_of_two(np.sqrt(np.asarray(conditions.multiply(conditions).sum(axis=1)).ravel()))
    rows, right = sparse.diags_array(1 / row) @ conditions, offset / row
    size = max(own, float(np.abs(right).max()))
    from scipy.optimize import linprog  # the import takes 0.25 s, and few problems get here

    proposed = linprog(
        right / size,
        A_eq=rows.T,
        b_eq=np.zeros(rows.shape[1]),
        bounds=[(0, 1)] * nc + [(-1, 1)] * (len(offset) - nc),
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if proposed.status != 0 or not proposed.fun < 0:
        return None
    weight = _polished(rows, np.asarray(proposed.x), nc)
    defect, gain = _sums(rows, right, weight)
    gain -= float(np.abs(weight[nc:]) @ np.maximum(CONTRADICTION * np.abs(right[nc:]), DEFECT_ROUNDING * size))
    if gain <= 0 or (weight[:nc] < 0).any() or not weight[:nc].any():
        return None  # joint equations hold to rounding, and a problem whose equations contradict each other by more is refused
    beyond = gain / (size * defect) if defect > 0 else np.inf
    if beyond < FAR:
        return None
    y, z = np.split(weight / row, [nc])
    least = gain * (1 - 1 / np.sqrt(beyond)) / float(y @ problem.units)
    largest = _power_of_two(np.array(max(y.max(initial=0.0), np.abs(z).max(initial=0.0))))  # exact, so that the proof holds
    return Contradiction(y / largest, z / largest, beyond, least)


def _conditions(problem: FrictionProblem) -> tuple[sparse.csr_array, Array, float]:
    """The rows of N and F for velocities scaled by masses, their offsets, and the problem's largest scaled velocity. If only W
    and q are known: the normal rows for scaled impulses."""
    if not problem.mechanical:
        root = _power_of_two(np.sqrt(np.repeat(problem.scale, problem.dimension)))
        normal = sparse.csr_array(problem.W[:: problem.dimension] @ sparse.diags_array(1 / root))
        return normal, problem.q[:: problem.dimension], float((np.abs(problem.q) / root).max(initial=0.0))
    root = _power_of_two(np.sqrt(problem.inverse_mass.diagonal()))
    rows = sparse.csr_array(sparse.vstack([problem.normal, problem.joints]) @ sparse.diags_array(root))
    own = float((np.abs(problem.free_velocity) / root).max(initial=0.0))
    return rows, np.concatenate([problem.bias, problem.joint_bias]), own


def _power_of_two(size: Array) -> Array:
    """The nearest powers of 2, by which scaling is exact; 1 for 0."""
    return np.exp2(np.rint(np.log2(np.where(size > 0, size, 1.0))))


def _polished(rows: sparse.csr_array, weight: Array, nc: int) -> Array:
    """The weights without negligible ones, corrected by least squares so that the defect is only rounding."""
    taken = np.abs(weight) > LEAST_WEIGHT * np.abs(weight).max()
    taken[nc:] = True
    part = rows[taken].toarray()
    polished = np.zeros_like(weight)
    own = weight[taken]
    polished[taken] = own - np.linalg.lstsq(part.T, part.T @ own, rcond=None)[0]
    polished[np.abs(polished) <= LEAST_WEIGHT * np.abs(polished).max()] = 0.0
    return polished


def _sums(rows: sparse.csr_array, right: Array, weight: Array) -> tuple[float, float]:
    """The 1-norm of the defect, and the gain, both summed in rational arithmetic."""
    defect: dict[int, Fraction] = {}
    gain = Fraction(0)
    for i in np.flatnonzero(weight).tolist():
        own = Fraction(weight[i])
        gain -= own * Fraction(right[i])
        for k in range(rows.indptr[i], rows.indptr[i + 1]):
            column = int(rows.indices[k])
            defect[column] = defect.get(column, Fraction(0)) + own * Fraction(rows.data[k])
    return float(sum(abs(entry) for entry in defect.values())), float(gain)
