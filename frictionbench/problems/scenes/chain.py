"""A chain of hinged links that is dragged over the ground: contacts and joints together, at any size."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import count, number
from frictionbench.problems.planar.bodies import half_plane, rigid_box
from frictionbench.problems.planar.joints import Hinge
from frictionbench.problems.scene import Scene


@generator()
def chain(
    links: int = 5,
    friction: float = 0.5,
    pull: float = 1.0,
    ripple: float = 0.0,
    fall: float = 0.0,
    mass_ratio: float = 1.0,
    step: float = 0.01,
    duration: float = 1.0,
) -> Scene:
    """Boxes 1 by 0.2, flat on the ground in a row and hinged to each other in the middle of their height, are pulled along.

    pull: m/s, of all of them, to the right. ripple: rad/s, spins of alternate sign, by which every second hinge is lifted at
    first. fall: m/s, downwards. mass_ratio: the mass of the last link over that of the first, geometric in between.
    """
    n, spin = count("links", links), number("ripple", ripple)
    density = number("mass_ratio", mass_ratio, above=0) ** (np.arange(n) / max(n - 1, 1))
    velocity = np.zeros((n, 3))
    velocity[:, 0] = number("pull", pull)
    velocity[:, 1] = spin / 2 - number("fall", fall)  # a link's one end is lifted by spin, the other stays
    velocity[:, 2] = spin * (-1.0) ** np.arange(n)
    return Scene(
        bodies=tuple(rigid_box(1.0, 0.2, float(rho)) for rho in density),
        obstacles=(half_plane(),),
        hinges=tuple(Hinge((i + 1, i), np.array([[-0.5, 0.0], [0.5, 0.0]])) for i in range(n - 1)),
        q0=np.column_stack([np.arange(n), np.full(n, 0.1), np.zeros(n)]),
        v0=velocity,
        friction=friction,
        step=step,
        duration=duration,
    )
