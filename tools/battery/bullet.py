"""Bullet, through PyBullet: sequential impulses with default settings, and with many iterations."""

from importlib import import_module
from typing import Any

import numpy as np

from tools.battery.world import Array, Setting, gravity


def stiff(setting: Setting, step: float) -> "Bullet":
    """Use a thousand iterations, without stopping at a small residual; with restitution, handle contacts only once bodies touch
    (contactProcessingThreshold)."""
    bullet = Bullet(setting, step, numSolverIterations=1000, solverResidualThreshold=0.0)
    if setting.restitution:
        bullet.only_touching()
    return bullet


class Bullet:
    """A setting as planes and multibodies. Bullet multiplies two bodies' coefficients, so each has the root of the contact's.

    Bullet's defaults apply, except for the step, without damping of motions, and with restitution at every speed.
    """

    def __init__(self, setting: Setting, step: float, **parameters: float) -> None:
        self._step = step
        self._bullet: Any = import_module("pybullet")
        self._own = {"physicsClientId": self._bullet.connect(self._bullet.DIRECT)}
        self._bullet.setPhysicsEngineParameter(fixedTimeStep=step, restitutionVelocityThreshold=0.0, **parameters, **self._own)
        self._bullet.setGravity(*setting.gravity, **self._own)
        for turn in setting.floors:
            normal = [0, -np.sin(turn), np.cos(turn)]
            self._add(setting, self._bullet.createCollisionShape(self._bullet.GEOM_PLANE, planeNormal=normal, **self._own), 0.0)
        self._bodies = []
        for body, inertia in zip(setting.bodies, setting.volume_inertia, strict=True):
            if len(body.size) == 1:
                shape = self._bullet.createCollisionShape(self._bullet.GEOM_SPHERE, radius=body.size[0], **self._own)
            else:
                shape = self._bullet.createCollisionShape(self._bullet.GEOM_BOX, halfExtents=body.size, **self._own)
            turned = self._bullet.getQuaternionFromEuler([body.turn, 0, 0])
            one = self._add(setting, shape, body.mass, basePosition=body.position, baseOrientation=turned)
            self._bullet.changeDynamics(one, -1, localInertiaDiagonal=inertia, linearDamping=0, angularDamping=0, **self._own)
            self._bullet.resetBaseVelocity(one, body.velocity, body.spin, **self._own)
            self._bodies.append(one)

    def _add(self, setting: Setting, shape: int, mass: float, **pose: Any) -> int:
        one = int(self._bullet.createMultiBody(mass, shape, **pose, **self._own))
        roots = np.sqrt([setting.friction, setting.restitution or 0.0])
        self._bullet.changeDynamics(one, -1, lateralFriction=roots[0], restitution=roots[1], **self._own)
        return one

    def only_touching(self) -> None:
        """Handle contacts only once bodies touch."""
        for one in range(self._bullet.getNumBodies(**self._own)):
            self._bullet.changeDynamics(one, -1, contactProcessingThreshold=0.0, **self._own)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / self._step)):
            self._bullet.stepSimulation(**self._own)

    def tilt(self, slope: float) -> None:
        self._bullet.setGravity(*gravity(slope), **self._own)

    def position(self, body: int) -> Array:
        return np.array(self._bullet.getBasePositionAndOrientation(self._bodies[body], **self._own)[0])

    def velocity(self, body: int) -> Array:
        return np.array(self._bullet.getBaseVelocity(self._bodies[body], **self._own)[0])
