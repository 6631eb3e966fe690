"""The central path of a friction problem, followed around its folds.

From a start x0, s0 > 0 with defect d0, the curve of all z = (x, s) and t with

    x ∘ s = t x0 ∘ s0,      H'u + K x - s = t d0,      F v + b_F = t times its value at the start,      t from 1 to 0,

leads to a solution. The problem is not monotone, so t need not decrease along it: the curve is parametrised by its length. Each
iteration factorises Newton's matrix once (solvers.interior.newton) and solves with it three times, for

    correction   towards the curve, orthogonal to its tangent; if it is short the next step is predicted, else it is repeated,
    tangent      z', t', of length 1,
    curvature    z'', t'', orthogonal to the tangent: the second derivative of x ∘ s is 2 z'_x ∘ z'_s, that of the rest 0,

and predicts z + tau z' + tau^2 z''/2, with tau such that the last term is small. Lengths and angles are measured in the
logarithms of x, s and t (the geodesics of solvers.interior.point), in which the cones have no boundaries. Steps, however, are
straight in x and s, so that all equations except the products hold exactly for every step length. Otherwise the velocities
would no longer match the impulses, and path following would fail where many contacts act on few bodies.

The direction along the tangent follows from the sign of det A: along a curve dt changes its sign together with the determinant
of the derivative with respect to (x, s), and nowhere else (Allgower and Georg 1990, section 2.1); that of the eliminated
contacts is positive. If this direction is opposite to that of the last step, the step has jumped to another branch and is
shortened.

A path that has used up its share of the work can be continued later: its state is kept in a Path.

When t is small, the faster predictor_corrector is tried from there. The curve may also go to t > 1, or be very long; then
another start is tried. This is rare if the speeds s0 are large compared with W x0: the problem at t = 1 then has nearly q > 0,
as on the ray on which Lemke's method starts. This is an observation, not a theorem.

References: Kojima, Megiddo, Noda and Yoshise 1991 (the path); Allgower and Georg 1990, chapters 2 to 6 (tracing a curve).
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean, part
from frictionbench.solvers.clock import late
from frictionbench.solvers.interior.newton import Work, direction, larger, linearise
from frictionbench.solvers.interior.point import Point, add_products, add_step, longest, new_point, set_step, to_geodesics
from frictionbench.solvers.interior.predictor_corrector import Best, evaluate_and_record, predictor_corrector
from frictionbench.solvers.interior.system import SOFTNESS, Space, System
from frictionbench.solvers.sparse_lu.multifrontal import determinant_sign

# Tuned by the numbers of solved problems and of factorisations. Steps are measured by their largest component in logarithms.
TERM = 0.08  # the second-order term of a prediction: larger steps need corrections, smaller ones more predictions
CONVERGED = 0.1  # after a correction up to this, the next step is predicted
TOO_LARGE_AT_FIRST, TOO_LARGE = 0.2, 1.0  # a first correction, and a later one, beyond which the last step is shortened
TURN = 0.7  # a step whose end makes an angle of smaller cosine with the tangent there has jumped branches, and is shortened
SHARP = 1e-3  # steps shorter than this are not checked for jumps: the curve itself may turn
SHORTER, SHORTEST = 0.4, 1e-7  # the factor of a shortened step, and the length at which the path is given up
MOST_CORRECTIONS = 3  # corrections of one prediction: Newton's method converges quadratically from CONVERGED
INSIDE = 0.98  # largest share of the way to the boundary, or to t = 0
HAND_OVER = 1e-4  # t at which the predictor-corrector is tried, and again after each further factor of this size
END, DIVERGED = 1e-20, 20.0  # t at which rounding hides all progress, and t beyond which no path was seen to return


class Path(NamedTuple):
    """A path: its start, the current point, and the last step, length * ahead + length² * curvature from the point `saved`."""

    start: Point
    point: Point
    saved: Point
    ahead: Point
    curvature: Point
    numbers: Array  # (8,): t, NaN once the path has ended, t at `saved`, rate, bend, length, hand_over, corrections, sign

    @property
    def ended(self) -> bool:
        """Whether the path has led to a solution or was abandoned."""
        return bool(np.isnan(self.numbers[0]))


def new_path(start: Point) -> Path:
    """The path from a start, which is not changed."""
    saved, ahead, curvature = (Point(*map(np.zeros_like, start)) for _ in range(3))
    numbers = np.array([1.0, 1.0, 0.0, 0.0, 0.0, HAND_OVER, 0.0, 0.0])
    return Path(start, Point(*map(np.copy, start)), saved, ahead, curvature, numbers)


@kernel
def trace(system: System, space: Space, path: Path, work: Work, best: Best, tol: float, patience: int, history: Array) -> int:
    """Continue the path until the residual is within tol, history is full, or the path is abandoned.

    patience: of the predictor-corrector. history receives the residual of every iterate; their number is returned.
    """
    point, saved, ahead, curvature, numbers = path.point, path.saved, path.ahead, path.curvature, path.numbers
    first, defect, correction, tangent, log_step = _five_points(system)
    log_tangent, trial = new_point(system), new_point(system)
    work.softness[0] = SOFTNESS
    evaluate_and_record(system, space, path.start, first, work, best)
    product, target = np.zeros((len(point.x), 4)), np.zeros((len(point.x), 4))
    _set_target(space, product, 0.0, target, -1.0, path.start)
    t, saved_t, rate, bend, length, hand_over = numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]
    used, corrections, initial_sign = 0, int(numbers[6]), int(numbers[7])
    numbers[0] = np.nan
    while used < len(history):
        history[used] = evaluate_and_record(system, space, point, defect, work, best)
        used += 1
        if best.residual[0] <= tol or not (history[used - 1] < np.inf and END < t < DIVERGED) or late(work.until):
            return used
        linearise(system, space, point, work)
        best.factorisations[0] += 1
        sign = determinant_sign(system.fronts, work.storage, work.swap)
        begins = initial_sign == 0
        if begins:
            initial_sign = sign
        orientation = -1.0 if sign == initial_sign else 1.0
        _set_target(space, target, t, product, 1.0, point)
        add_step(defect, -t, first)
        direction(system, space, point, target, defect, correction, work)
        _set_target(space, target, t, product, 0.0, point)
        set_step(defect, -t, first)
        direction(system, space, point, target, defect, tangent, work)
        set_step(log_tangent, 1.0, tangent)
        to_geodesics(system, space, point, log_tangent)
        square = 1 + _dot(log_tangent, log_tangent)
        cosine = 1.0
        if length > SHARP and corrections == 0:  # ahead + 2 length curvature is the derivative at the end of the step
            set_step(log_step, 1.0, ahead)
            add_step(log_step, 2 * length, curvature)
            to_geodesics(system, space, point, log_step)
            change = (rate + 2 * length * bend) / t
            cosine = orientation * (_dot(log_step, log_tangent) + change)
            cosine /= np.sqrt(square * (_dot(log_step, log_step) + change * change))
        back = _orthogonal(system, space, point, correction, log_step, tangent, log_tangent, square)
        off = larger(_size(log_step), abs(back))
        allowed = TOO_LARGE_AT_FIRST if corrections == 0 else TOO_LARGE
        if not begins and (not off <= allowed or not cosine >= TURN or corrections > MOST_CORRECTIONS):
            length *= SHORTER
            corrections = 0
            if length < SHORTEST:
                return used
        else:
            share = min(1.0, INSIDE * longest(system, space, point, correction, 1 / INSIDE), INSIDE / larger(INSIDE, abs(back)))
            if off > CONVERGED:
                add_step(point, share, correction)
                t *= 1 + share * back
                corrections += 1
                continue
            corrections = 0
            set_step(saved, 1.0, point)
            add_step(saved, share, correction)
            saved_t = t * (1 + share * back)
            if saved_t < hand_over and used < len(history):
                set_step(trial, 1.0, saved)
                used += predictor_corrector(system, space, trial, work, best, tol, patience, history[used:])
                hand_over *= HAND_OVER
                if best.residual[0] <= tol:
                    return used
                work.softness[0] = SOFTNESS
                linearise(system, space, point, work)
                best.factorisations[0] += 1
            rate = orientation / np.sqrt(square)
            set_step(ahead, rate, tangent)
            _set_target(space, target, 0.0, product, 1.0, ahead)
            set_step(defect, 0.0, first)
            direction(system, space, point, target, defect, curvature, work)
            bend = t * _orthogonal(system, space, point, curvature, log_step, tangent, log_tangent, square)
            rate *= t
            length = np.sqrt(TERM / larger(_size(log_step), abs(bend) / t))
        while True:
            set_step(trial, length, ahead)
            add_step(trial, length * length, curvature)
            change = length * (rate + length * bend)
            if longest(system, space, saved, trial, 1 / INSIDE) >= 1 / INSIDE and saved_t + change > (1 - INSIDE) * saved_t:
                break
            length *= 0.8
            if not SHORTEST <= length < np.inf:  # as after an overflow or underflow
                return used
        set_step(point, 1.0, saved)
        add_step(point, 1.0, trial)
        t = saved_t + change
    numbers[:] = np.array([t, saved_t, rate, bend, length, hand_over, float(corrections), float(initial_sign)])
    return used


@part
def _five_points(system: System) -> tuple[Point, Point, Point, Point, Point]:
    return new_point(system), new_point(system), new_point(system), new_point(system), new_point(system)


@lean
def _set_target(space: Space, target: Array, t: float, product: Array, share: float, point: Point) -> None:
    """target = t product - share x ∘ s."""
    for i in range(len(target)):
        for k in range(4):
            target[i, k] = t * product[i, k]
    add_products(space, -share, point.x, point.s, target)


@lean
def _orthogonal(
    system: System, space: Space, point: Point, step: Point, log_step: Point, tangent: Point, log_tangent: Point, square: float
) -> float:
    """Make the step (step, 0) orthogonal to (tangent, 1), in logarithms of (z, t); return its component for t."""
    set_step(log_step, 1.0, step)
    to_geodesics(system, space, point, log_step)
    back = -_dot(log_step, log_tangent) / square
    add_step(log_step, back, log_tangent)
    add_step(step, back, tangent)
    return float(back)


@lean
def _dot(a: Point, b: Point) -> float:
    total = 0.0
    for i in range(len(a.x)):
        for k in range(4):
            total += a.x[i, k] * b.x[i, k] + a.s[i, k] * b.s[i, k]
    return total


@lean
def _size(step: Point) -> float:
    """The largest component, infinity if one is NaN."""
    largest = 0.0
    for i in range(len(step.x)):
        for k in range(4):
            largest = larger(larger(largest, abs(step.x[i, k])), abs(step.s[i, k]))
    return largest
