"""The scheme of forces and accelerations (Baraff 1993; Pfeiffer and Glocker 1996), whose equations may have no solution.

    M a = k + J' f + F' lam,      F a + F. v = 0,      v+ = v + h a,      q+ = q + h v+,
    0 <= n'a + n'. v ⟂ f_n >= 0,      f_t = -mu sign(t'v) f_n  where a contact slides,  |f_t| <= mu f_n where it does not,

at the contacts that touch at q. A dot is the rate along v, computed by finite differences. The law is imposed on
n'v + h (n'a + n'. v), which is equivalent if n'v = 0, so that rounding errors in n'v do not grow. A contact slides if the
external force cannot stop it in one step. If a touching contact approaches, an impact precedes the step
(problems.schemes.impact).

For a given direction of sliding, a force need not exist: if Painlevé's rod slides with
p = n'M^-1 (n - mu sign(t'v) t) < 0, every f_n > 0 accelerates it downwards. NoSolution is then raised.

The direction of sliding is imposed by belts (problems.schemes.events.forces).
"""

import numpy as np

from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.events.forces import SWIFT, on_belts, rates, require_moving_belts
from frictionbench.problems.schemes.impact import approaching, impact
from frictionbench.problems.schemes.stepping import Solve, Solved, Step, free_velocity, respond, scheme


@scheme("acceleration")
def acceleration(scene: Scene, now: Step, solve: Solve) -> Step:
    """One step of length scene.step. Errors: NoSolution if no force satisfies the law."""
    h, q, v = scene.step, now.q, now.v
    contacts = scene.contacts(q)
    solved: list[Solved] = []
    if approaching(scene, v, contacts).any():
        solved, v = impact(scene, q, v, contacts, solve)
    free = free_velocity(scene, now, v)
    normal_rate, _, joint_rate = rates(scene, q, v, contacts)
    if (contacts.normal @ free + h * normal_rate >= 0).all():  # zero forces are a solution
        contacts, normal_rate = contacts.only(np.zeros(len(contacts), dtype=bool)), normal_rate[:0]
    problem = scene.friction_problem(q, free, contacts, bias=h * normal_rate, joint_bias=h * joint_rate)

    slip = (contacts.tangent @ v).reshape(len(contacts), scene.dimension - 1)
    push = np.abs(problem.jacobian @ (free - v)).max(initial=0.0)
    pace = np.linalg.norm(slip, axis=1)
    slides = pace > (1 + scene.coefficients(contacts)) * push + scene.touch / h
    speed = SWIFT * (np.abs(problem.jacobian @ v).max(initial=0.0) + push)
    belts = np.zeros(slip.shape)
    belts[slides] = speed * slip[slides] / pace[slides, None]
    if slides.any():
        problem = on_belts(problem, np.flatnonzero(slides), belts[slides])
    step, after = respond("step", problem, contacts, solve)
    require_moving_belts(problem, step.impulse, belts, contacts, now.time)
    after = after[: len(v)]
    return Step(now.time + h, scene.moved(q, h * after), after, contacts, (*solved, step))
