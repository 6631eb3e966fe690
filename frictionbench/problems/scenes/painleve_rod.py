"""Painlevé's rod (1895), as an impulse problem: page 6 of the talk (Anitescu 1999)."""

import math

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import number
from frictionbench.problems.planar.bodies import half_plane, rigid_rod
from frictionbench.problems.scene import Scene


@generator(friction=1.5, duration=1.0)
def painleve_rod(
    angle: float = math.atan(2.0),
    tip_velocity: float = -1.0,
    spin: float = 0.0,
    lift: float = 0.0,
    mass: float = 1.0,
    half_length: float = 1.0,
) -> Scene:
    """A rod that leans to the right slides on the ground on its lower tip; forces alone cannot always stop it.

    While the tip slides to the left, a unit normal force gives it the normal acceleration p = (1 + 3 cos^2 - 3 mu |sin cos|)/m.
    With t = tan(angle), p < 0 iff mu > (4 + t^2)/(3 t), which is least at t = 2, where it is 4/3. If p < 0 and
    half_length spin^2 sin < g, no force prevents penetration. An impulse stops the tip within one step. In the limit h -> 0

        r_n = 3/4 m sin cos |v_t|,    r_t = 1/4 m (1 + 3 cos^2) |v_t|,    losing m (1 + 3 cos^2) v_t^2 / 8.

    If p < 0 and the tip lifts, with lift > g h, the impulse problem has three solutions: it opens, sticks or slides.

    angle: rad from the ground. tip_velocity: m/s along the ground, negative to the left. lift: m/s, of the tip. spin: rad/s.
    """
    angle = number("angle", angle, above=0, most=np.pi / 2)
    spin, speed = number("spin", spin), number("tip_velocity", tip_velocity)
    length = number("half_length", half_length, above=0)
    cos, sin = length * np.cos(angle), length * np.sin(angle)
    return Scene(
        bodies=(rigid_rod(length, number("mass", mass, above=0)),),
        obstacles=(half_plane(),),
        q0=np.array([cos, sin, angle]),
        v0=np.array([speed - spin * sin, number("lift", lift) + spin * cos, spin]),
    )
