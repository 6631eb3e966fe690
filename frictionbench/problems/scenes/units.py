"""A scene in other units of mass and length; the unit of time is unchanged, and the motion is the same.

A solver whose results depend on the units has an absolute tolerance.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.planar.joints import Hinge
from frictionbench.problems.scene import Scene


def in_units(scene: Scene, mass: float, length: float) -> Scene:
    """The scene with every mass multiplied by `mass` and every length by `length`.

    Errors: InputError where the scene has no bodies: generalised coordinates may be lengths, angles or anything.
    """
    require(bool(scene.bodies), "mass_unit, length_unit", "a scene in generalised coordinates has its own units only")

    def scaled(state: Array, size: int) -> Array:
        """The first d of `size` entries of each body are lengths."""
        unit = np.ones(size)
        unit[: scene.dimension] = length
        return state * np.tile(unit, len(scene.bodies))

    return replace(
        scene,
        bodies=tuple(body.scaled(mass, length) for body in scene.bodies),
        obstacles=tuple(obstacle.scaled(length) for obstacle in scene.obstacles),
        hinges=tuple(Hinge(hinge.bodies, hinge.points * length) for hinge in scene.hinges),
        q0=scaled(scene.q0, scene.geometry.coordinates),
        v0=scaled(scene.v0, scene.geometry.velocities),
        gravity=tuple(length * g for g in scene.gravity),
        path=scene.path and partial(_lengths, scene.path, length),
    )


def _lengths(path: Callable[[float], Array], length: float, time: float) -> Array:
    return length * path(time)
