"""Mehrotra's predictor-corrector method on a friction problem, in the velocities of the bodies.

The iterates keep x and s inside their cones (solvers.interior.point) and need not be feasible. Each iteration factorises
Newton's matrix (solvers.interior.newton) once and solves with it twice: the predictor aims at x ∘ s = 0; how far it gets sets
the centring sigma; the corrector aims at

    x ∘ s = sigma mean(x s),      sigma = (mean(x s) after the predictor / mean(x s))^2,

with the predictor's second-order term, and takes .995 of the way to the boundary, the same step length for x and s, because the
problem is not monotone. Convergence is not guaranteed: where the central path folds, no step decreases x s, and the method
stops for lack of progress. References: Mehrotra 1992; Wright 1997, chapter 10.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import lean, lean_kernel
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import late
from frictionbench.solvers.interior.newton import Work, direction, evaluate_point, linearise
from frictionbench.solvers.interior.point import Point, add_products, add_step, longest, set_identity
from frictionbench.solvers.interior.system import SOFTNESS, Space, System

SOFTER, SOFTEST = 100.0, 1e-10  # the factor by which delta grows if progress ends near a solution, and the largest delta
NEAR = 1e-5  # the residual up to which rounding, rather than a fold of the path, may end progress
TO_BOUNDARY = 0.995  # share of the way to the boundary: Mehrotra's choice, close enough to 1 for superlinear convergence


class Best(NamedTuple):
    """The impulses (nc, d) with the smallest residual (1,) so far, in the system's units; factorisations (1,) so far."""

    impulse: Array
    residual: Array
    factorisations: Index64


def nothing_yet(nc: int, d: int) -> Best:
    return Best(np.zeros((nc, d)), np.full(1, np.inf), np.zeros(1, np.int64))


@lean
def evaluate_and_record(system: System, space: Space, point: Point, defect: Point, work: Work, best: Best) -> float:
    """Evaluate a point, and store its impulses if it is the best so far."""
    residual = evaluate_point(system, space, point, defect, work)
    if residual < best.residual[0]:
        best.residual[0] = residual
        for i in range(len(best.impulse)):
            for k in range(best.impulse.shape[1]):
                best.impulse[i, k] = work.impulse[i, k]
    return residual


@lean_kernel
def predictor_corrector(
    system: System, space: Space, point: Point, work: Work, best: Best, tol: float, patience: int, history: Array
) -> int:
    """Move the point to a solution; stop when the residual is within tol, history is full, or no progress is made.

    Progress means that the sum of mean(x s) and the largest defect halves within `patience` iterations. Without progress at a
    residual up to NEAR, the softness delta of Newton's matrix (solvers.interior.newton) is first increased, up to SOFTEST.
    history receives the residual of every iterate; their number is returned.
    """
    x, s, step, defect, target = point.x, point.s, work.step, work.defect, work.target
    pairs, work.softness[0] = 0, SOFTNESS
    for i in range(len(x)):
        pairs += system.pairs[i]
    milestone, since = np.inf, 0
    for iteration in range(len(history)):
        history[iteration] = evaluate_and_record(system, space, point, defect, work, best)
        gap, off = 0.0, 0.0
        for i in range(len(x)):
            for k in range(4):
                gap += x[i, k] * s[i, k]
                off = max(off, abs(defect.x[i, k]))
        gap /= pairs
        since += 1
        if not gap + off > milestone / 2:
            milestone, since = gap + off, 0
        if best.residual[0] <= tol or not gap + off < np.inf or late(work.until):
            return iteration + 1
        if since > patience:
            if history[iteration] > NEAR or work.softness[0] > SOFTEST / SOFTER:
                return iteration + 1
            work.softness[0] *= SOFTER
            milestone, since = gap + off, 0
        linearise(system, space, point, work)
        best.factorisations[0] += 1
        set_identity(space, 0.0, target)
        add_products(space, -1.0, x, s, target)
        direction(system, space, point, target, defect, step, work)
        length = longest(system, space, point, step, 1.0)
        ahead = 0.0
        for i in range(len(x)):
            for k in range(4):
                ahead += (x[i, k] + length * step.x[i, k]) * (s[i, k] + length * step.s[i, k])
        sigma = (ahead / pairs / gap) ** 2
        set_identity(space, sigma * gap, target)
        add_products(space, -1.0, x, s, target)
        add_products(space, -1.0, step.x, step.s, target)
        direction(system, space, point, target, defect, step, work)
        length = min(1.0, TO_BOUNDARY * longest(system, space, point, step, 1 / TO_BOUNDARY))
        add_step(point, length, step)
    return len(history)
