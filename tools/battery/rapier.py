"""Rapier, through its Python package: with default settings, and with more substeps and stiffer contacts."""

from importlib import import_module
from typing import Any

import numpy as np

from tools.battery.world import Array, Setting, gravity


def stiff(setting: Setting, step: float) -> "Rapier":
    """Use 20 substeps instead of 4, and contacts of 300 Hz, ten and five times as fast as by default."""
    world = Rapier(setting, step)
    parameters = world.world.integration_parameters
    parameters.num_solver_iterations = 20
    for name in ("contact_softness", "static_contact_softness"):
        setattr(parameters, name, world.rapier.SpringCoefficients(300.0, getattr(parameters, name).damping_ratio))
    return world


class Rapier:
    """A setting as half spaces and rigid bodies in single precision. Rapier averages two bodies' coefficients.

    Rapier's defaults apply, except for the step, and bodies do not go to sleep.
    """

    def __init__(self, setting: Setting, step: float) -> None:
        r = self.rapier = import_module("rapier3d")
        self.world: Any = r.PhysicsWorld(gravity=tuple(setting.gravity))
        self.world.integration_parameters.dt = step
        for turn in setting.floors:
            self.world.add_collider(_material(setting, r.Collider.halfspace((0, -np.sin(turn), np.cos(turn)))))
        self._step, self._bodies = step, []
        for body in setting.bodies:
            shape = r.Collider.ball(*body.size) if len(body.size) == 1 else r.Collider.cuboid(*body.size)
            builder = r.RigidBodyBuilder().translation(tuple(body.position)).rotation((body.turn, 0, 0))
            builder = builder.linvel(tuple(body.velocity)).angvel(tuple(body.spin)).can_sleep(False)
            self._bodies.append(self.world.add_body(builder, [_material(setting, shape.mass(body.mass))]))

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / self._step)):
            self.world.step()

    def tilt(self, slope: float) -> None:
        self.world.gravity = tuple(gravity(slope))

    def position(self, body: int) -> Array:
        at = self.world.rigid_bodies[self._bodies[body]].translation
        return np.array([at.x, at.y, at.z])

    def velocity(self, body: int) -> Array:
        v = self.world.rigid_bodies[self._bodies[body]].linvel
        return np.array([v.x, v.y, v.z])


def _material(setting: Setting, collider: Any) -> Any:
    return collider.friction(setting.friction).restitution(setting.restitution or 0.0)
