"""Lötstedt's scheme (1984): the normal impulse of the previous step limits the friction of this step.

    M (v+ - v) = h k + J' r + F' lam,      q+ = q + h v+,      F v+ = 0,
    0 <= n'v+ ⟂ r_n >= 0,      |r_t| <= mu r_n(before),  r_t opposing the slip,

at the contacts that touch at q. With known limits, friction is a convex problem, so every step has a solution with a unique
velocity. The limits lag by one step: the error is O(h) in smooth motion, and a contact has no friction in its first step, that
is, at the start and in impacts. Contacts of successive steps are matched by their features. There is no law of restitution.
"""

import numpy as np

from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.stepping import Solve, Step, free_velocity, respond, scheme


@scheme("lotstedt", lacks=("restitution",))
def lotstedt(scene: Scene, now: Step, solve: Solve) -> Step:
    """One step of length scene.step."""
    h, q = scene.step, now.q
    contacts = scene.contacts(q)
    before = {}
    if now.solved:
        normal = now.solved[-1].impulse[:, 0].clip(min=0)
        before = dict(zip(map(tuple, now.contacts.feature.tolist()), normal, strict=True))
    limit = scene.coefficients(contacts) * np.array([before.get(tuple(feature), 0.0) for feature in contacts.feature.tolist()])
    problem = scene.friction_problem(q, free_velocity(scene, now, now.v), contacts, friction_bias=limit)
    step, v = respond("step", problem.replace(friction=np.zeros(len(contacts))), contacts, solve)
    return Step(now.time + h, scene.moved(q, h * v), v, contacts, (step,))
