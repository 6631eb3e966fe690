"""An arch of voussoirs, which stands by its thrust and the friction of its joints."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import count, number
from frictionbench.problems.planar.bodies import half_plane, homogeneous
from frictionbench.problems.scene import Scene


@generator()
def arch(
    stones: int = 7, friction: float = 0.5, thickness: float = 0.3, push: float = 0.0, step: float = 0.01, duration: float = 1.0
) -> Scene:
    """A semicircular arch of equal stones on the ground.

    It stands iff it is thick enough for a line of thrust (for many stones thickness >= 0.107, Heyman 1969) and no joint
    slides. The middle line has the radius 1 m. thickness: m. push: m/s, of the middle stone, to the right.
    """
    n, thick = count("stones", stones, least=2), number("thickness", thickness, above=0, most=1)
    half = np.pi / n / 2
    inner, outer = 1 - thick / 2, 1 + thick / 2
    corners = np.array([[outer, -half], [outer, half], [inner, half], [inner, -half]])
    stone = corners[:, :1] * np.column_stack([np.cos(corners[:, 1]), np.sin(corners[:, 1])])
    body, centre = homogeneous(stone)
    bodies = (body,) * n
    turn = np.pi - half * (2 * np.arange(n) + 1)
    velocity = np.zeros((n, 3))
    velocity[n // 2, 0] = number("push", push)
    return Scene(
        bodies=bodies,
        obstacles=(half_plane(),),
        q0=np.column_stack([centre[0] * np.cos(turn), centre[0] * np.sin(turn), turn]),
        v0=velocity,
        friction=friction,
        step=step,
        duration=duration,
    )
