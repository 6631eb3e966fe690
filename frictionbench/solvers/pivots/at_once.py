"""Lemke's method for few contacts in the plane: form, solution and residual in one compiled call.

For up to ten contacts most of the time is that of the calls, not of the pivots. Here one kernel finds q, W and the units, forms
and scales the LCP, follows the path (solvers.lemke), and computes the residual from velocities, with the same operations as the
separate calls, so that the results are the same to the last bit. Problems with joints, and those with islands of unlike speeds
(solvers.balanced), are left to the separate calls.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.delassus import delassus, known_measures, measures
from frictionbench.problems.forms.lcp import impulse, tangent_basis
from frictionbench.problems.residual import TOL_SHARE, known_with_floor, mechanical_with_floor
from frictionbench.solvers.balanced import UNLIKE
from frictionbench.solvers.clock import deadline
from frictionbench.solvers.interface import impulses
from frictionbench.solvers.lemke import NO_BASIS, RESTARTS, guess_bases, lemke
from frictionbench.solvers.pivots.scaled_lcp import scaled_friction_lcp

BASIS = tangent_basis(2)


def lemke_at_once(
    problem: FrictionProblem, tol: float, limit: int | None, start: Array | None
) -> tuple[Array, float, float, dict[str, int]] | None:
    """The impulses (nc, 2) of a planar problem without joints, their residual and its floor, and the counts of work.

    tol, limit, start: as for solvers.lemke. None if islands have unlike speeds.
    """
    mu, b_f, nc, guess = problem.friction, problem.friction_bias, problem.contacts, NO_BASIS
    if start is not None:
        guess, _ = guess_bases(np.array([0, nc]), impulses(start, (nc, 2)), mu, b_f, BASIS)
    settings = mu, b_f, BASIS, guess, tol, limit or 0, deadline()
    if problem.mechanical:
        rows = *problem.contact_rows, *problem.inverse_rows
        r, error, floor, *counts = _mechanical(*rows, problem.free_velocity, problem.bias, *settings)
    else:
        r, error, floor, *counts = _known(*problem.blocks, problem.q, *settings)
    work = dict(zip(("pivots", "restarts", "inversions"), counts, strict=True))
    return None if len(r) < nc else (r, error, floor, work)


@kernel
def _mechanical(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, free, bias, mu, b_f, basis, guess, tol, pivots, until
):
    q, scale, _, units, unlike = measures(start, column, J, m_start, m_column, m_value, free, bias, b_f, np.zeros(0))
    if unlike > UNLIKE:
        return np.zeros((0, 2)), np.inf, 0.0, 0, 0, 0
    law, W = (mu, b_f, scale, units), delassus(start, column, J, m_start, m_column, m_value)
    r, counts = _solve(*W, q, law, basis, guess, tol, pivots, until)
    error, floor = mechanical_with_floor(start, column, J, m_start, m_column, m_value, free, r, bias, scale, mu, b_f, units)
    return r, error, floor, *counts


@kernel
def _known(first, neighbours, block, q, mu, b_f, basis, guess, tol, pivots, until):  # type: ignore[no-untyped-def]
    scale, units, unlike = known_measures(first, neighbours, block, q, b_f, np.zeros(0))
    if unlike > UNLIKE:
        return np.zeros((0, 2)), np.inf, 0.0, 0, 0, 0
    r, counts = _solve(first, neighbours, block, q, (mu, b_f, scale, units), basis, guess, tol, pivots, until)
    error, floor = known_with_floor(first, neighbours, block, r, q.reshape(r.shape), scale, mu, b_f, units)
    return r, error, floor, *counts


@part
def _solve(first, neighbours, block, q, law, basis, guess, tol, pivots, until):  # type: ignore[no-untyped-def]
    """The impulses, and the pivots, restarts and inversions. law: mu, b_f, scale and units."""
    mu, b_f, scale, units = law
    stretch, M, right, unit = scaled_friction_lcp(first, neighbours, block, q, mu, b_f, basis, scale, units)
    limits = TOL_SHARE * tol, pivots, RESTARTS, until
    _, pivots, restarts, inversions, y = lemke(M, right, unit, len(mu), guess, True, *limits)
    return impulse(basis, stretch * y, len(mu)), (pivots, restarts, inversions)
