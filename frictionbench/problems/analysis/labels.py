"""Labels of a friction problem: size, rank, pointedness, triviality.

Labels serve to exclude trivial problems from headline results, and to split results by the causes of difficulty. For most
methods this is the rank deficiency of W rather than the lack of convexity (Acary, Brémond and Huber 2018). Whether a problem is
idle depends on an answer: see problems.analysis.frictionless.
"""

from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import cholesky, svdvals
from scipy.optimize import linprog

from frictionbench.problems.check import Array
from frictionbench.problems.forms.definite import spectrum_ends
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import residual
from frictionbench.problems.subproblems import keep_contacts

DENSE_ROWS = 600  # the most rows of W for dense decompositions; beyond, they cost more than solving the problem
ZERO_RESIDUAL = 1e-12  # r = 0 is an answer if its residual is up to this
POINTED = 1e-9  # the pointedness up to which it counts as 0, because of rounding
RANK_ROUNDING = 1e3  # times the rounding error of a matrix product: smaller singular values count as zero
FACETS = 8  # of the polygon in space, the default of FrictionProblem.lcp


def labels(problem: FrictionProblem) -> dict[str, Any]:
    """All labels of a problem, by the names of their columns (results.schema).

    size: of the friction LCP (lcp_size).
    rank, condition: of W; the condition is the largest divided by the smallest nonzero singular value. redundancy: the rows of
    W minus its rank. All are None above DENSE_ROWS rows, where a dense singular value decomposition costs more than solving the
    problem. The condition of W = 0 is None.
    pointedness: see pointedness(); 0 if the friction cone is pointed.
    p0_margin: the least (a - mu |b|)/a over contacts, with a = W_nn and b = W_nt of the contact's own block. A single contact
    has a P0 matrix iff this is nonnegative (in space |b| is a norm, and the margin a lower bound); 1 without contacts.
    mass_ratio: the ratio of the largest to the smallest effective mass at contacts, 1/s of FrictionProblem.scale; 1 without
    contacts. largest_friction: the largest coefficient of friction; 0 without contacts.
    asymmetry: that of FrictionProblem. indefiniteness: minus the ratio of the smallest to the largest eigenvalue of W's
    symmetric part, as estimated by problems.forms.definite, or 0 if it is negative. Both are 0 if the mechanics are given.
    islands: the number of islands of the contact graph (problems.forms.islands). island_ratio: the ratio of the largest to the
    smallest unit of the contacts, which are those of their islands; 1 if nothing moves.
    limits, dry_friction: the numbers of contacts that represent joint limits and dry friction of joints (see FrictionProblem).
    trivial: why there is nothing to solve, or "": "no contact", "no friction", or "no impulse" if r = 0 is the only answer. It
    is not the only one if the friction cone of the contacts closed at r = 0 is not pointed, as in a jam.
    """
    nc, d = problem.contacts, problem.dimension
    rank, condition = _rank_condition(problem) if nc * d <= DENSE_ROWS else (None, None)
    limit, dry = joint_rows(problem)
    least, largest = (0.0, 0.0) if problem.mechanical else spectrum_ends(problem.W)
    return {
        "contacts": nc,
        "dimension": d,
        "velocities": len(problem.free_velocity),
        "size": lcp_size(problem),
        "rank": rank,
        "condition": condition,
        "redundancy": None if rank is None else nc * d - rank,
        "pointedness": pointedness(problem),
        "p0_margin": p0_margin(problem),
        "mass_ratio": float(problem.scale.max() / problem.scale.min()) if nc else 1.0,
        "largest_friction": float(problem.friction.max(initial=0.0)),
        "asymmetry": problem.asymmetry,
        "indefiniteness": max(0.0, -least / largest) if largest > 0 else 0.0,
        "islands": int(problem.islands.max(initial=-1)) + 1,
        "island_ratio": problem.spread,
        "limits": int(limit.sum()),
        "dry_friction": int(dry.sum()),
        "trivial": _trivial(problem),
    }


def lcp_size(problem: FrictionProblem) -> int:
    """The unknowns nc (K + 2) of the friction LCP, with K = 2 in the plane and FACETS in space."""
    return problem.contacts * ((2 if problem.dimension == 2 else FACETS) + 2)


def joint_rows(problem: FrictionProblem) -> tuple[Array, Array]:
    """Whether each contact (nc,) represents a joint limit, and whether it represents dry friction of a joint."""
    size = abs(problem.jacobian).sum(axis=1) if problem.mechanical else problem.W.diagonal()
    rows = np.reshape(size, (-1, problem.dimension)) > 0
    normal, tangent = rows[:, 0], rows[:, 1:].any(axis=1)
    smooth = problem.friction == 0
    return smooth & normal & ~tangent, smooth & tangent & ~normal & (problem.friction_bias > 0)


def p0_margin(problem: FrictionProblem) -> float:
    """The least (a - mu |b|)/a over contacts; see labels."""
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return 1.0
    first = np.arange(nc) * d
    a = problem.W.diagonal()[first]
    b = np.linalg.norm([np.ravel(problem.W[first, first + k]) for k in range(1, d)], axis=0)
    return float(np.min(1 - problem.friction * b / np.where(a > 0, a, 1.0)))


def _trivial(problem: FrictionProblem) -> str:
    if not problem.contacts:
        return "no contact"
    if not problem.friction.any() and not problem.friction_bias.any():
        return "no friction"
    if residual(problem, np.zeros((problem.contacts, problem.dimension))) > ZERO_RESIDUAL:
        return ""
    closed = problem.q[:: problem.dimension] <= ZERO_RESIDUAL * problem.units
    squeezed = pointedness(keep_contacts(problem, np.flatnonzero(closed).tolist()))
    return "" if squeezed > POINTED else "no impulse"


def _rank_condition(problem: FrictionProblem) -> tuple[int, float | None]:
    """The rank and the condition number of W = A A', from the singular values of A, the square roots of those of W, because
    forming an ill-conditioned W loses half its digits. If only W is known, its own singular values are used.

    For the rank, each contact's rows of A are divided by their norm without joints. The rank then does not depend on mass
    ratios, and rows that joints cancel are recognised as rounding errors.
    """
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return 0, None
    if not problem.mechanical:
        root = np.repeat(np.sqrt(problem.scale), d)
        W = problem.W.toarray()
        rank, values = _rank(W / np.outer(root, root)), svdvals(W)
        return rank, float(values[0] / values[rank - 1]) if rank else None
    root = cholesky(problem.inverse_mass.toarray(), lower=True)
    A, G = problem.jacobian @ root, problem.joints @ root
    size = np.repeat(np.linalg.norm(A.reshape(nc, -1), axis=1), d)[:, None]
    if len(G):
        A = A - (A @ np.linalg.pinv(G)) @ G
    rank, values = _rank(A / np.where(size > 0, size, 1.0)), svdvals(A)
    return rank, float((values[0] / values[rank - 1]) ** 2) if rank else None


def _rank(A: Array) -> int:
    """The rank of A, whose rows have norms of about 1 unless they have cancelled."""
    return int(np.sum(svdvals(A) > RANK_ROUNDING * max(A.shape) * np.finfo(float).eps))


def pointedness(problem: FrictionProblem) -> float:
    """max { sum c : J'(c, beta) + F' lam = 0, |beta| <= mu c, 0 <= c <= 1 }, by linear programming; polygonal in space.

    This is the normal impulse that the contacts can exchange without moving anything. If the friction cone is pointed, it is 0
    and the data bound the impulses. For a body jammed between two walls it is 2. It is NaN if the program is not solved, or if
    only W is known and has more than DENSE_ROWS rows, for which the dense program takes too long.
    """
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return 0.0
    angle = 2 * np.pi * np.arange(FACETS) / FACETS
    directions = np.array([[1.0, -1.0]]) if d == 2 else np.array([np.cos(angle), np.sin(angle)])
    K = directions.shape[1]
    eye = sparse.eye_array(nc)
    # Nothing moves iff J' r = 0. If only W is known, iff W r = 0, which is the same if W is J M^-1 J'.
    if not problem.mechanical and nc * d > DENSE_ROWS:
        return np.nan
    push = sparse.csr_array(problem.jacobian.T) if problem.mechanical else problem.W / (problem.W.max() or 1.0)
    tangential = np.arange(nc * d) % d > 0
    D = push[:, tangential] @ sparse.kron(eye, directions)
    momentum = sparse.hstack([push[:, ~tangential], D, problem.joints.T], format="csr")
    size = abs(momentum).max(axis=1).toarray().ravel()
    momentum = sparse.diags_array(1 / np.where(size > 0, size, 1.0)) @ momentum  # so that units do not matter
    nj = problem.joints.shape[0]
    cone = sparse.hstack(
        [-sparse.diags_array(problem.friction), sparse.kron(eye, np.ones((1, K))), sparse.csr_array((nc, nj))], format="csr"
    )
    result = linprog(
        np.concatenate([-np.ones(nc), np.zeros(nc * K + nj)]),
        A_ub=cone,
        b_ub=np.zeros(nc),
        A_eq=momentum,
        b_eq=np.zeros(momentum.shape[0]),
        bounds=[(0, 1)] * nc + [(0, None)] * (nc * K) + [(None, None)] * nj,
        method="highs-ipm",
    )
    return max(0.0, -float(result.fun)) if result.status == 0 else np.nan
