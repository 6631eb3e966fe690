"""Compliant contact: springs and dampers with regularised friction, integrated as a stiff differential equation.

    f_n = max(0, -k g - c g.) where g < 0,      f_t = -mu f_n tanh(t'v/s),      M v' = force + N' f_n + T' f_t,    q' = v

with the gap g, the stiffness k and a speed s. c = 2 z sqrt(k m) gives the restitution e of a single contact with the effective
mass m = 1/(n'M^-1 n) that does not pull:

    e = exp(-2 z acos(z)/sqrt(1 - z^2)),     with acosh and z^2 - 1 if z > 1;

e is at least LEAST_RESTITUTION, since e = 0 would need an infinite z. As k increases and s decreases, the motion tends to one
of the rigid model. If there are several, the state of the springs determines which.

Reference: Schwager and Pöschel, Granular Matter 9 (2007), pages 465-469, for e.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from frictionbench.problems import InputError, Scene
from studies.study import Array

LEAST_RESTITUTION = 0.01  # the least restitution


class CompliantMotion(NamedTuple):
    """times (n,), s, of the states q (n, nq) and v (n, nv); evaluations: the number of evaluations of the forces."""

    times: Array
    q: Array
    v: Array
    evaluations: int


@cache
def damping_ratio(restitution: float) -> float:
    """Return z for this e in [0, 1]."""

    def excess(z: float) -> float:
        exponent = z * np.arccos(z) / np.sqrt(1 - z * z) if z < 1 else z * np.arccosh(z) / np.sqrt(z * z - 1)
        return float(np.exp(-2 * exponent)) - max(restitution, LEAST_RESTITUTION)

    return 0.0 if restitution == 1 else float(brentq(excess, 1e-12, 50.0))


def comply(
    scene: Scene,
    stiffness: float,
    slip: float = 1e-4,
    accuracy: float = 1e-8,
    times: Array | None = None,
    method: str = "Radau",
) -> CompliantMotion:
    """Return the scene's motion at these times, by default at its steps.

    scene: planar and without hinges. stiffness: N/m. slip: the speed s, m/s. accuracy: the integrator's, relative. method:
    scipy's Radau or BDF. Errors: InputError if the integrator fails.
    """
    nv, at = len(scene.v0), np.arange(scene.steps + 1) * scene.step if times is None else times
    evaluations = 0

    def slope(time: float, y: Array) -> Array:
        nonlocal evaluations
        evaluations += 1
        q, v = y[:nv], y[nv:]
        force, contacts = scene.force(q, v, time), scene.contacts(q, 0.0)
        if len(contacts):
            N, T = contacts.normal_rows.dense(nv), contacts.tangent_rows.dense(nv)
            mass = 1 / (N.T * scene.accelerate(q, N.T)).sum(axis=0)
            ratio = np.array([damping_ratio(e) for e in scene.restitutions(contacts).tolist()])
            normal = np.maximum(0.0, -stiffness * contacts.gap - 2 * ratio * np.sqrt(stiffness * mass) * (N @ v))
            force = force + N.T @ normal - T.T @ (scene.coefficients(contacts) * normal * np.tanh(T @ v / slip))
        return np.concatenate([v, scene.accelerate(q, force)])

    speed = max(
        scene.fastest(scene.v0), np.sqrt(np.abs(scene.accelerate(scene.q0, scene.force(scene.q0, scene.v0, 0.0))).max())
    )
    scale = np.repeat([scene.reach, speed], nv)
    y0 = np.concatenate([scene.q0, scene.v0])
    largest = scene.duration / 100  # so that no contact is missed in free flight
    done = solve_ivp(slope, (0.0, at[-1]), y0, method=method, t_eval=at, rtol=accuracy, atol=accuracy * scale, max_step=largest)
    if not done.success:
        raise InputError(f"scene: its compliant motion cannot be integrated: {done.message}")
    return CompliantMotion(done.t, done.y[:nv].T, done.y[nv:].T, evaluations)
