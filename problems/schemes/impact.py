"""Impact with Poisson's law of restitution, in two phases without external forces (Anitescu and Potra 1997, section 3).

Compression brings the contacts to rest with impulses whose normal parts are c. Decompression returns e c, and whatever
impulses (x, y) it takes to keep the contacts apart, with friction bounded by the whole impulse, |y| <= mu (x + e c). With one
e for all contacts, the energy after an impact is at most that before less (1 - e^2)/2 |p|^2 in the metric of M^-1, p the
compression impulse. An impact needs bodies that hit: a scheme that slows them down before they touch loses restitution.
"""

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.stepping import Solve, Solved, respond


def approaching(scene: Scene, v: Array, contacts: Contacts) -> NDArray[np.bool_]:
    """Which contacts (nc,) close at v by more than scene.touch within a step."""
    return np.asarray(scene.step * (contacts.normal @ v) < -scene.touch)


def impact(scene: Scene, q: Array, v: Array, contacts: Contacts, solve: Solve) -> tuple[list[Solved], Array]:
    """Let the contacts, whatever their gaps, hit at the velocity v; the phases' problems, and the velocity (nv,) afterwards."""
    compression, v = respond("compression", scene.friction_problem(q, v, contacts), solve)
    if not scene.restitution:
        return [compression], v
    returned = scene.restitution * compression.impulse[:, 0].clip(min=0)
    thrown = v + (contacts.normal.T @ returned) / scene.weights
    rebound = scene.friction_problem(q, thrown, contacts, friction_bias=scene.friction * returned)
    decompression, v = respond("decompression", rebound, solve)
    return [compression, decompression], v
