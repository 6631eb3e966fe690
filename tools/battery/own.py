"""This project's rigid contacts: a time-stepping scheme whose friction problems are solved exactly."""

from dataclasses import replace

import numpy as np

from frictionbench.problems import SCHEMES, FrictionProblem, HalfSpace, Scene, solid_box, solid_sphere, start
from frictionbench.solvers import solve
from tools.battery.world import Array, Setting, gravity

SOLVER, TOLERANCE = "interior_point", 1e-8


class Exact:
    """A setting as a scene, by Anitescu and Potra's scheme, with Poisson's law of restitution."""

    def __init__(self, setting: Setting, step: float) -> None:
        half = np.array([body.turn for body in setting.bodies])[:, None] / 2
        turn = np.hstack([np.cos(half), np.sin(half), np.zeros((len(half), 2))])  # quaternions
        self._scene = Scene(
            bodies=tuple(
                solid_sphere(body.size[0], body.mass) if len(body.size) == 1 else solid_box(body.size, body.mass)
                for body in setting.bodies
            ),
            obstacles=tuple(HalfSpace(np.array([0.0, -np.sin(floor), np.cos(floor)])) for floor in setting.floors),
            q0=np.hstack([np.array([body.position for body in setting.bodies], dtype=float), turn]),
            v0=np.array([[*body.velocity, *body.spin] for body in setting.bodies], dtype=float),
            friction=setting.friction,
            restitution=setting.restitution or 0.0,
            gravity=tuple(setting.gravity),
            step=step,
        )
        self._step, self._scheme = start(self._scene), SCHEMES["anitescu_potra"]

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / self._scene.step)):
            self._step = self._scheme(self._scene, self._step, _solved)

    def tilt(self, slope: float) -> None:
        self._scene = replace(self._scene, gravity=tuple(gravity(slope)))

    def position(self, body: int) -> Array:
        return self._scene.geometry.centres(self._step.q)[body]

    def velocity(self, body: int) -> Array:
        return self._step.v.reshape(-1, 6)[body, :3]


def _solved(problem: FrictionProblem) -> Array:
    return solve(problem, SOLVER, tol=TOLERANCE).impulse
