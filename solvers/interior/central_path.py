"""The central path of a friction problem, followed around its folds.

From a start x0, s0 > 0 with defect d0, the curve of all (x, s, t) with

    x ∘ s = t x0 ∘ s0,      H'u + K x - s = t d0,      F v + b_F = t times its value at the start,      t from 1 to 0,

leads to a solution. The problem is not monotone, so t need not decrease along it: the curve is followed by its length, in the
logarithms of x, s and t (the geodesics of solvers.interior.point), in which the cones' boundaries disappear and the curve is
straight near a solution, however fast the pairs vanish. Each iteration factorises Newton's matrix once
(solvers.interior.newton), for both parts of a step:

    correction   towards the curve, orthogonal to its tangent; as often as it takes, but the first one too long is taken back,
    prediction   along the tangent, the longer the smaller the correction that the last one caused.

Which way along the tangent is told by the sign of det A: along a curve dt changes its sign together with the determinant of
the derivative by (x, s), and nowhere else (Allgower and Georg 1990, section 2.1), and that of the eliminated contacts is
positive. The angle with the last tangent, the usual criterion, turns round where t is small and a corner is sharp, and the path
goes back to where it came from. With the determinant a step across a corner may only exchange branches.

Where t is small and the point on the curve, the faster predictor_corrector is tried from there.

It may also leave to t > 1, or wind on for long; then another start is tried. Speeds s0 large against W x0 make that rare: the
problem at t = 1 then has nearly q > 0, as for the ray on which Lemke's method starts. This is an observation and not a theorem.

References: Kojima, Megiddo, Noda and Yoshise 1991 (the path); Allgower and Georg 1990, chapters 2 to 6 (tracing a curve).
"""

import numpy as np

from problems.check import Array
from problems.compiled import kernel, part
from solvers.interior.elements import larger
from solvers.interior.newton import direction, linearise
from solvers.interior.point import Point, add_products, add_step, move_along, new_point, set_step, to_geodesics
from solvers.interior.predictor_corrector import Best, Room, judge, predictor_corrector
from solvers.interior.system import Space, System
from solvers.sparse_lu.multifrontal import determinant_sign

NEAR = 0.2  # a correction, in logarithms, up to which a point counts as on the curve
FAR = 1.0  # and from which the prediction is taken back
AIM = 0.3  # what the length of a prediction aims at
HALFWAY = 0.5  # a correction is no longer than this
MOST = 12  # corrections of one prediction
FIRST, LONGEST, SHORTEST = 0.1, 3.0, 1e-7  # predictions, in logarithms
HAND_OVER = np.log(1e-4)  # log t at which the predictor-corrector is tried, and again by each of these further on
END, LOST = np.log(1e-20), 3.0


@kernel
def trace(system: System, space: Space, point: Point, room: Room, best: Best, tol: float, patience: int, history: Array) -> int:
    """Follow the path from the point; stop where the residual is within tol, history is full, or the path is lost.

    patience: that of the predictor-corrector, where it is tried. history receives the residual of every iterate; their
    number is returned.
    """
    first, defect, correction, tangent = new_point(system), new_point(system), new_point(system), new_point(system)
    ahead, saved, trial, work = new_point(system), new_point(system), new_point(system), room.work
    judge(system, space, point, first, work, best)
    product, target = np.zeros((len(point.x), 4)), np.zeros((len(point.x), 4))
    _aim(space, product, 0.0, target, -1.0, point)
    log_t, saved_log_t, ahead_log_t = 0.0, 0.0, -1.0
    length, hand_over = FIRST, HAND_OVER
    used, corrections, inwards = 0, 0, 0
    while used < len(history):
        history[used] = judge(system, space, point, defect, work, best)
        used += 1
        if best.residual[0] <= tol or length < SHORTEST or not END < log_t < LOST:
            return used
        linearise(system, space, point, work)
        best.factorisations[0] += 1
        sign = determinant_sign(system.fronts, work.storage, work.swap)
        if used == 1:
            inwards = sign
        t = np.exp(log_t)
        _aim(space, target, t, product, 1.0, point)
        add_step(defect, -t, first)
        direction(system, space, point, target, defect, correction, work)
        _aim(space, target, t, product, 0.0, point)
        set_step(defect, -t, first)
        direction(system, space, point, target, defect, tangent, work)
        to_geodesics(system, space, point, correction)
        to_geodesics(system, space, point, tangent)
        back = -_dot(correction, tangent) / (1 + _dot(tangent, tangent))
        add_step(correction, back, tangent)
        off = max(_size(correction), abs(back))
        if (used > 1 and not off <= (FAR if corrections == 0 else np.inf)) or corrections > MOST:
            set_step(point, 1.0, saved)
            log_t, corrections = saved_log_t, 0
            length /= 4
        else:
            share = min(1.0, HALFWAY / max(off, HALFWAY))
            move_along(system, space, point, correction, share)
            log_t += share * back
            if off > NEAR:
                corrections += 1
                continue
            if log_t < hand_over and used < len(history):
                set_step(trial, 1.0, point)
                used += predictor_corrector(system, space, trial, room, best, tol, patience, history[used:])
                hand_over += HAND_OVER
            if corrections > 1:
                length /= 2
            elif corrections == 0 and used > 1:
                length = min(LONGEST, length * min(2.0, max(0.3, np.sqrt(AIM / max(off, 1e-9)))))
            corrections = 0
            set_step(saved, 1.0, point)
            saved_log_t = log_t
            ahead_log_t = (-1.0 if sign == inwards else 1.0) / max(_size(tangent), 1.0)
            set_step(ahead, ahead_log_t, tangent)
        move_along(system, space, point, ahead, length)
        log_t += length * ahead_log_t
    return used


@part
def _aim(space: Space, target: Array, t: float, product: Array, share: float, point: Point) -> None:
    """target = t product - share x ∘ s."""
    for i in range(len(target)):
        for k in range(4):
            target[i, k] = t * product[i, k]
    add_products(space, -share, point.x, point.s, target)


@part
def _dot(a: Point, b: Point) -> float:
    total = 0.0
    for i in range(len(a.x)):
        for k in range(4):
            total += a.x[i, k] * b.x[i, k] + a.s[i, k] * b.s[i, k]
    return total


@part
def _size(step: Point) -> float:
    """The largest component, infinity where one is not a number."""
    largest = 0.0
    for i in range(len(step.x)):
        for k in range(4):
            largest = larger(larger(largest, abs(step.x[i, k])), abs(step.s[i, k]))
    return largest
