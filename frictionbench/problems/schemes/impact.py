"""Impact with Poisson's law of restitution, in two phases without external forces (Anitescu and Potra 1997, section 3).

Compression brings the contacts to rest with impulses whose normal parts are c. Decompression applies e c, and the
impulses (x, y) that prevent penetration, with friction bounded by the total impulse, |y| <= mu (x + e c). With one
e for all contacts, the energy after an impact is at most that before less (1 - e^2)/2 |p|^2 in the metric of M^-1, p the
compression impulse. A scheme that reduces the approach velocity before bodies touch loses restitution.
"""

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.stepping import Solve, Solved, respond


def approaching(scene: Scene, v: Array, contacts: Contacts) -> NDArray[np.bool_]:
    """Whether each contact (nc,) closes at v by more than scene.touch within a step."""
    return np.asarray(scene.step * (contacts.normal @ v) < -scene.touch)


def impact(scene: Scene, q: Array, v: Array, contacts: Contacts, solve: Solve) -> tuple[list[Solved], Array]:
    """The impact of the contacts, whatever their gaps, at velocity v: the phases' problems and the velocity (nv,) after."""
    compression, v = respond("compression", scene.friction_problem(q, v, contacts), contacts, solve)
    if not scene.restitution:
        return [compression], v
    returned = scene.restitutions(contacts) * compression.impulse[:, 0].clip(min=0)
    thrown = v + scene.accelerate(q, contacts.normal.T @ returned)
    rebound = scene.friction_problem(q, thrown, contacts, friction_bias=scene.coefficients(contacts) * returned)
    decompression, v = respond("decompression", rebound, contacts, solve)
    return [compression, decompression._replace(returned=returned)], v
