"""Impact with Poisson's law of restitution, in two phases without external forces (Anitescu and Potra 1997, section 3).

Compression brings the contacts to rest with impulses whose normal parts are c. Decompression applies e c and the impulses
(x, y) that prevent penetration, with friction bounded by the total impulse, |y| <= mu (x + e c). If all contacts have the same
e, an impact dissipates at least (1 - e^2)/2 |p|^2, where p is the compression impulse and the norm that of M^-1. A scheme that
reduces the approach velocity before bodies touch loses restitution.
"""

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.stepping import Solve, Solved, respond


def approaching(scene: Scene, v: Array, contacts: Contacts) -> NDArray[np.bool_]:
    """Whether each contact (nc,) closes by more than scene.touch within a step at velocity v."""
    return np.asarray(scene.step * (contacts.normal @ v) < -scene.touch)


def impact(scene: Scene, q: Array, v: Array, contacts: Contacts, solve: Solve) -> tuple[list[Solved], Array]:
    """The impact of the contacts, for any gaps, at velocity v: the problems of its phases and the velocity (nv,) after it."""
    compression, v = respond("compression", scene.friction_problem(q, v, contacts), contacts, solve)
    if not scene.restitution:
        return [compression], v
    returned = scene.restitutions(contacts) * compression.impulse[:, 0].clip(min=0)
    thrown = v + scene.accelerate(q, contacts.normal.T @ returned)
    rebound = scene.friction_problem(q, thrown, contacts, friction_bias=scene.coefficients(contacts) * returned)
    decompression, v = respond("decompression", rebound, contacts, solve)
    return [compression, decompression._replace(returned=returned)], v
