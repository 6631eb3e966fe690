"""Mehrotra's predictor-corrector method on a friction problem, in the velocities of the bodies.

The iterates keep x and s inside their cones (solvers.interior.point) and need not be feasible. Each iteration factorises
Newton's matrix (solvers.interior.newton) once and solves with it twice: the predictor aims at x ∘ s = 0; how far it gets sets
the centring sigma; the corrector aims at

    x ∘ s = sigma mean(x s),      sigma = (mean(x s) after the predictor / mean(x s))^2,

with the predictor's second-order term, and goes .995 of the way to the boundary, x and s together, for the problem is not
monotone. Nor is there a guarantee: where the central path folds, no step is left that decreases x s, and the method has to
notice. References: Mehrotra 1992; Wright 1997, chapter 10.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from problems.check import Array
from solvers.interior.newton import direction, evaluate, linearise
from solvers.interior.point import Point, add_products, add_step, longest, new_point, set_identity
from solvers.interior.system import System, Work, new_work
from solvers.sparse_lu.minimum_degree import Index

TO_BOUNDARY = 0.995


class Best(NamedTuple):
    """The impulses (nc, d) with the smallest residual (1,) so far, in the system's units; factorisations (1,) so far."""

    impulse: Array
    residual: Array
    factorisations: Index


@njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
def judge(system: System, point: Point, defect: Point, work: Work, best: Best) -> float:
    """Evaluate a point and remember the best one."""
    residual = evaluate(system, point, defect, work)
    if residual < best.residual[0]:
        best.residual[0] = residual
        for i in range(len(best.impulse)):
            for k in range(best.impulse.shape[1]):
                best.impulse[i, k] = work.impulse[i, k]
    return residual


@njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
def predictor_corrector(system: System, point: Point, best: Best, tol: float, patience: int, history: Array) -> int:
    """Move the point to a solution; stop where the residual is within tol, history is full, or no progress is made.

    Progress is that mean(x s) and the largest defect, added, halve within `patience` iterations.
    history receives the residual of every iterate; their number is returned.
    """
    step, defect, target = new_point(system), new_point(system), np.zeros((len(point.x), 4))
    return _iterate(system, point, step, defect, target, new_work(system), best, tol, patience, history)


@njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
def _iterate(
    system: System,
    point: Point,
    step: Point,
    defect: Point,
    target: Array,
    work: Work,
    best: Best,
    tol: float,
    patience: int,
    history: Array,
) -> int:
    """The iterations, with room to work in: a loop over arrays of its own would count references to them at every call."""
    x, s = point.x, point.s
    pairs = system.pairs.sum()
    milestone, since = np.inf, 0
    for iteration in range(len(history)):
        history[iteration] = judge(system, point, defect, work, best)
        gap, off = 0.0, 0.0
        for i in range(len(x)):
            for k in range(4):
                gap += x[i, k] * s[i, k]
                off = max(off, abs(defect.x[i, k]))
        gap /= pairs
        since += 1
        if not gap + off > milestone / 2:
            milestone, since = gap + off, 0
        if best.residual[0] <= tol or since > patience or not gap + off < np.inf:
            return iteration + 1
        linearise(system, point, work)
        best.factorisations[0] += 1
        target[:] = 0
        add_products(system, -1.0, x, s, target)
        direction(system, point, target, defect, step, work)
        length = longest(system, point, step, 1.0)
        ahead = 0.0
        for i in range(len(x)):
            for k in range(4):
                ahead += (x[i, k] + length * step.x[i, k]) * (s[i, k] + length * step.s[i, k])
        sigma = (ahead / pairs / gap) ** 2
        set_identity(system, sigma * gap, target)
        add_products(system, -1.0, x, s, target)
        add_products(system, -1.0, step.x, step.s, target)
        direction(system, point, target, defect, step, work)
        length = min(1.0, TO_BOUNDARY * longest(system, point, step, 1 / TO_BOUNDARY))
        add_step(point, length, step)
    return len(history)
