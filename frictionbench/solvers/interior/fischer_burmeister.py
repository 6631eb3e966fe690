"""Semismooth Newton on the Fischer-Burmeister equation of planar contacts, in the velocities of the bodies.

The pairs x, s of planar contacts (solvers.interior.point) are complementary exactly where Phi = 0,

    Phi = phi(x, s),     phi(a, b) = a + b - sqrt(a² + b²),

all in units of velocity: the impulse of each pair is multiplied by the contact's weight. Unlike in an interior point method, x
is any vector, and s = H'u + K x always holds. A and B, the derivatives of phi with respect to x and s, are between 0 and 2, and
a step solves

    A dx + B ds = -Phi,     ds = H'du + K dx,

which are the equations of an interior point with A and B in place of s and x (solvers.interior.newton), so that a step costs
one sparse factorisation. Its length is halved until |Phi|²/2 is below the largest of the last MEMORY merits (De Luca, Facchinei
and Kanzow 1996; Grippo, Lampariello and Lucidi 1986). The softness that keeps Newton's matrix regular is reduced after a full
step and increased after a short one, like the damping of Levenberg and Marquardt's method.

No path is followed: most random contact graphs take some twenty steps, whatever their size. The problem is not monotone, so
that the iteration may end in a local minimum of |Phi|.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean
from frictionbench.solvers.clock import late
from frictionbench.solvers.interior.newton import Work, direction, linearise
from frictionbench.solvers.interior.point import Point, add_step, new_point, set_step
from frictionbench.solvers.interior.predictor_corrector import Best, evaluate_and_record
from frictionbench.solvers.interior.system import Space, System

ARMIJO = 1e-4  # required share of the predicted decrease: the usual constant
MEMORY = 20  # merits with which a step is compared
SHORTEST = 1e-6  # length at which a step is given up
FIRST_SOFTNESS, LEAST_SOFTNESS, MOST_SOFTNESS = 0.1, 1e-6, 1.0  # of the first step, the least, and that above which it stops
ADAPT, SHORT = 3.0, 0.3  # the factor by which softness changes, and the step length below which it grows
LEAST_SLOPE = 1e-10  # lower bound of A and B, by which the equations of an interior point divide


@kernel
def fischer_burmeister(
    system: System, space: Space, point: Point, work: Work, best: Best, tol: float, patience: int, history: Array
) -> int:
    """Move the point's x to a solution; stop when the residual is within tol, history is full, or no step descends.

    history receives the residual of every iterate; their number is returned.
    """
    step, defect, target = work.step, work.defect, work.target
    derivative, trial, merits = new_point(system), new_point(system), np.zeros(MEMORY)
    none = np.zeros((len(point.x), 4))
    exact, along = Point(none, none, defect.joint), Point(step.x, none, step.joint)  # s is not an unknown: it follows from x
    work.softness[0] = FIRST_SOFTNESS
    for i in range(len(point.s)):
        for k in range(4):
            point.s[i, k] = 0.0  # so that the defect H'u + K x - s is the partner of x
    for iteration in range(len(history)):
        history[iteration] = evaluate_and_record(system, space, point, defect, work, best)
        merit = _equation(system, point, defect, target, derivative)
        if best.residual[0] <= tol or not merit < np.inf or late(work.until) or work.softness[0] > MOST_SOFTNESS:
            return iteration + 1
        merits[iteration % MEMORY] = merit
        linearise(system, space, derivative, work)
        best.factorisations[0] += 1
        direction(system, space, derivative, target, exact, step, work)
        slope = _slope(system, derivative, target, step, merit, work.softness[0])
        length = 1.0 if slope < 0 else 0.0
        while length > 0:
            set_step(trial, 1.0, point)
            add_step(trial, length, along)
            evaluate_and_record(system, space, trial, defect, work, best)
            if _equation(system, trial, defect, target, derivative) <= merits.max() + ARMIJO * length * slope:
                set_step(point, 1.0, trial)
                break
            length = length / 2 if length > SHORTEST else 0.0
        if length == 1.0:
            work.softness[0] = max(LEAST_SOFTNESS, work.softness[0] / ADAPT)
        elif length < SHORT:
            work.softness[0] *= ADAPT
    return len(history)


@lean
def _equation(system: System, point: Point, partner: Point, target: Array, derivative: Point) -> float:
    """|Phi|²/2, including the joints' velocities. Writes -Phi to target, and B and A, as x and s of a point, to derivative."""
    x, s, merit = point.x, partner.x, 0.0
    for i in range(len(x)):
        for k in range(system.pairs[i]):
            of_x, of_s = (system.weight[i], 1.0) if k < 3 else (1.0, system.weight[i])
            a, b = of_x * x[i, k], of_s * s[i, k]
            h = np.sqrt(a * a + b * b)
            phi = 2 * a * b / (a + b + h) if a + b > 0 else a + b - h
            target[i, k] = -phi
            merit += phi * phi / 2
            ratio_a, ratio_b = (a / h, b / h) if h > 0 else (np.sqrt(0.5), np.sqrt(0.5))
            derivative.s[i, k] = max(1 - ratio_a, LEAST_SLOPE) * of_x
            derivative.x[i, k] = max(1 - ratio_b, LEAST_SLOPE) * of_s
    for j in range(len(partner.joint)):
        merit += partner.joint[j, 0] ** 2 / 2
    return merit


@lean
def _slope(system: System, derivative: Point, target: Array, step: Point, merit: float, softness: float) -> float:
    """The derivative of the merit along a step that solves the softened equations."""
    slope = -2 * merit
    for i in range(len(target)):
        for k in range(system.pairs[i]):
            soft = softness * system.weight[i] if k < 3 else softness / system.weight[i]
            slope += target[i, k] * derivative.x[i, k] * soft * step.x[i, k]
    return slope
