"""The distance between the velocities of two answers, and the refinement of an answer up to rounding.

Different impulses may give the same motion. Outcomes are therefore compared by velocities, in the metric of the mass matrix and
relative to the change that contact causes:

    distance = |v - v*|_M / |v* - v_0|_M,      |v|_M^2 = v'M v,

where v* are the velocities of a reference answer and v_0 those without contact impulses, which satisfy the joint equations. If
only W and q are known, |v - v*|_M^2 = (r - r*)'(u - u*).

In an ill-conditioned problem, an answer within a tolerance may be far from any solution. It is therefore refined first, by
Newton's method for Alart and Curnier's equations in x = s r/unit and w = u/unit, for each contact

    open    x = 0                                        if x_n - w_n <= 0
    closed  w_n = 0, and with y = x_t - w_t, L = mu x_n + b:     w_t = 0 if |y| <= L,     x_t = L y/|y| otherwise.

Redundant contacts make the Jacobian J of these equations E singular. A step solves (J'J + DAMPING) dx = -J'E in the augmented
form [[DAMPING, J'], [J, -1]], which does not square the condition number of J. Steps are small in singular directions of J, so
that the result stays near the given answer. A step is accepted only if the residual decreases.

References: Alart and Curnier 1991; Yamashita and Fukushima 2001 (Levenberg and Marquardt near solutions that are not isolated).
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from frictionbench.problems.check import Array
from frictionbench.problems.forms.islands import NOISE
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import residual, residual_floor

REFINED_RESIDUAL = 1e-12  # the residual of a refined answer, unless its rounding floor is larger
DAMPING = 1e-13  # relative to squares of singular values: those below 3e-7 count as zero
STEPS = 12  # most of them are needed if the damped part converges linearly
HALVINGS = 4


def velocity_distance(problem: FrictionProblem, impulse: Array, reference: Array) -> float | None:
    """The distance of the velocities of impulse (nc, d) from those of the reference (nc, d); None if contact changes nothing
    beyond rounding or if a shape is wrong."""
    shape = problem.contacts, problem.dimension
    if impulse.shape != shape or reference.shape != shape or not np.isfinite(impulse).all():
        return None
    change, size = problem.contact_velocity(reference) - problem.q.reshape(shape), problem.velocity_size(reference)
    changed = _norm(problem, reference, np.zeros(shape)) if (np.abs(change) > NOISE * size).any() else 0.0
    return _norm(problem, impulse, reference) / changed if changed > 0 else None


def _norm(problem: FrictionProblem, one: Array, other: Array) -> float:
    if problem.mechanical:
        change = problem.velocity(one) - problem.velocity(other)
        return float(np.sqrt(change @ (problem.mass @ change)))
    change = problem.contact_velocity(one) - problem.contact_velocity(other)
    return float(np.sqrt(max(np.sum((one - other) * change), 0.0)))


def refined(problem: FrictionProblem, impulse: Array) -> Array | None:
    """The answer (nc, d) refined until its residual is REFINED_RESIDUAL or within its floor; None if this is not reached.

    Errors: InputError naming impulse if it is not an array of numbers.
    """
    r, least = impulse, residual(problem, impulse)
    if not np.isfinite(least):
        return None
    sizes = problem.scale / problem.units
    r = np.where(r == 0, 0.0, r)
    W = sparse.diags_array(np.repeat(1 / problem.units, problem.dimension)) @ problem.W
    W = sparse.csr_array(W @ sparse.diags_array(np.repeat(1 / sizes, problem.dimension)))
    for _ in range(STEPS):
        if least <= REFINED_RESIDUAL / 100:
            break
        step = _step(problem, sizes[:, None] * r, W) / sizes[:, None]
        share, error = 1.0, np.inf
        for _ in range(HALVINGS):
            if (error := residual(problem, r + share * step)) < least:
                break
            share /= 4
        if not error < least:
            break
        r, least = r + share * step, error
    return r if least <= max(REFINED_RESIDUAL, residual_floor(problem, r)) else None


def _step(problem: FrictionProblem, x: Array, W: sparse.csr_array) -> Array:
    """The damped Newton step in x (nc, d). W: the matrix that maps x to w."""
    nc, d = x.shape
    w = problem.contact_velocity(x * (problem.units / problem.scale)[:, None]) / problem.units[:, None]
    mu, bias = problem.friction, problem.friction_bias * problem.scale / problem.units
    closed = x[:, 0] > w[:, 0]
    y = x[:, 1:] - w[:, 1:]
    size, limit = np.linalg.norm(y, axis=1), np.where(closed, mu * np.maximum(x[:, 0], 0.0), 0.0) + bias
    slides = size > limit
    along = y / np.where(size > 0, size, 1.0)[:, None]
    of_x, of_w, error = np.zeros((nc, d, d)), np.zeros((nc, d, d)), np.zeros((nc, d))
    of_x[:, 0, 0], of_w[:, 0, 0], error[:, 0] = ~closed, closed, np.where(closed, w[:, 0], x[:, 0])
    turn = (np.eye(d - 1) - along[:, :, None] * along[:, None, :]) * (limit / np.where(size > 0, size, 1.0))[:, None, None]
    stuck = (~slides)[:, None, None]
    of_x[:, 1:, 1:] = np.where(stuck, 0.0, np.eye(d - 1) - turn)
    of_w[:, 1:, 1:] = np.where(stuck, np.eye(d - 1), turn)
    of_x[:, 1:, 0] = np.where((slides & closed)[:, None], -mu[:, None] * along, 0.0)
    error[:, 1:] = np.where(slides[:, None], x[:, 1:] - limit[:, None] * along, w[:, 1:])
    J = sparse.block_diag(of_x, format="csr") + sparse.block_diag(of_w, format="csr") @ W
    eye = sparse.eye_array(nc * d)
    system = sparse.csc_array(sparse.block_array([[DAMPING * eye, J.T], [J, -eye]]))
    solution = splu(system).solve(np.concatenate([np.zeros(nc * d), -error.ravel()]))
    return np.asarray(solution[: nc * d]).reshape(nc, d)
