"""A scene in other units of mass and length; the unit of time is unchanged, and the motion is the same.

A solver whose results depend on the units has an absolute tolerance.
"""

from dataclasses import replace

import numpy as np

from frictionbench.problems.planar.bodies import Shape
from frictionbench.problems.planar.joints import Hinge
from frictionbench.problems.scene import Scene


def in_units(scene: Scene, mass: float, length: float) -> Scene:
    """The scene with every mass multiplied by `mass` and every length by `length`."""

    def scaled(shape: Shape) -> Shape:
        return replace(shape, corners=shape.corners * length, radius=shape.radius * length)

    unit = np.tile([length, length, 1.0], len(scene.bodies))
    return replace(
        scene,
        bodies=tuple(
            replace(
                body, mass=body.mass * mass, inertia=body.inertia * mass * length**2, shapes=tuple(map(scaled, body.shapes))
            )
            for body in scene.bodies
        ),
        obstacles=tuple(map(scaled, scene.obstacles)),
        hinges=tuple(Hinge(hinge.bodies, hinge.points * length) for hinge in scene.hinges),
        q0=scene.q0 * unit,
        v0=scene.v0 * unit,
        gravity=(scene.gravity[0] * length, scene.gravity[1] * length),
    )
