"""Contact forces and accelerations as a friction problem (Baraff 1993; Pfeiffer and Glocker 1996).

With the acceleration a, the contact forces f, and a dot for the rate along v, at closed contacts with zero normal velocity,

    M a = k + J' f + F' lam,      F a + F. v = 0,      u = J a + J. v,      0 <= u_n ⟂ f_n >= 0,

    f_t = -mu sign(t'v) f_n where a contact slides,      |f_t| <= mu f_n, opposing u_t, where it does not.

The direction of sliding is imposed so that the equations remain a friction problem: a sliding contact rests on a belt, an
additional body that moves in the direction of the slip, SWIFT times faster than everything else. Friction does not depend on
the speed of the slip, so the forces are the same for every speed at which the belt continues to move. If a correct answer stops
a belt, the forces are unbounded in the limit of fast belts, and the equations have no solution.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.residual import residual
from frictionbench.problems.rows import Index64
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.stepping import NoSolution, Solve, Solved

SWIFT = 1e3  # the belts' speed, relative to the contacts' speeds and to their change by the external force
SOLVED_RESIDUAL = 1e-6  # the residual up to which an answer counts as a solution of the scheme's equations
NUDGE = 1e-5  # the displacement of finite differences, relative to the largest body: balances rounding and truncation errors


class Rates(NamedTuple):
    """J. v and F. v: normal (nc,), tangent (nc, d - 1) and joint (nj,), m/s^2."""

    normal: Array
    tangent: Array
    joint: Array


def rates(scene: Scene, q: Array, v: Array, contacts: Contacts) -> Rates:
    """The rates by central differences along v; 0 for contacts that do not exist at both ends."""
    nc, nj, nv, d = len(contacts), 2 * len(scene.hinges), len(v), scene.dimension
    way = NUDGE * scene.reach
    fastest = np.abs(v).max(initial=0.0) * max(1.0, scene.reach)
    if not fastest or not (nc or nj):
        return Rates(np.zeros(nc), np.zeros((nc, d - 1)), np.zeros(nj))
    eps = way / fastest
    ahead, behind = scene.moved(q, eps * v), scene.moved(q, -eps * v)
    speeds_at = []
    for place in (ahead, behind):
        near = scene.contacts(place, scene.touch + 10 * way)
        speeds = [near.normal_rows.dense(nv) @ v, *(near.tangent_rows.dense(nv) @ v).reshape(-1, d - 1).T]
        speeds_at.append(dict(zip(map(tuple, near.feature.tolist()), np.column_stack(speeds), strict=True)))
    after, before = speeds_at
    features = [tuple(feature) for feature in contacts.feature.tolist()]
    lasting = [after[f] - before[f] if f in after and f in before else np.zeros(d) for f in features]
    contact = np.array(lasting).reshape(-1, d) / (2 * eps)
    joint = (scene.joints(ahead)[1] - scene.joints(behind)[1]) @ v / (2 * eps) if nj else np.zeros(0)
    return Rates(contact[:, 0], contact[:, 1:], joint)


def on_belts(problem: FrictionProblem, contacts: Index64, velocities: Array) -> FrictionProblem:
    """The problem with a belt of given velocity (n, d - 1) under each of these contacts (n,), which adds d - 1 velocities."""
    n = velocities.size
    nc, nj, tangents = problem.contacts, problem.joints.shape[0], velocities.shape[1]
    row = (tangents * contacts[:, None] + np.arange(tangents)).ravel()
    belt = sparse.csr_array((np.ones(n), (row, np.arange(n))), shape=(nc * tangents, n))
    return problem.replace(
        mass=sparse.block_diag([problem.mass, problem.mass.diagonal().max() * sparse.eye_array(n)], format="csr"),
        normal=sparse.hstack([problem.normal, sparse.csr_array((nc, n))], format="csr"),
        tangent=sparse.hstack([problem.tangent, belt], format="csr"),
        joints=sparse.hstack([problem.joints, sparse.csr_array((nj, n))], format="csr"),
        free_velocity=np.concatenate([problem.free_velocity, velocities.ravel()]),
    )


def require_moving_belts(problem: FrictionProblem, impulse: Array, belts: Array, contacts: Contacts, time: float) -> None:
    """Errors: NoSolution if a correct answer stops a belt. belts: their velocities (nc, d - 1), 0 where there is none."""
    speed = np.linalg.norm(belts, axis=1)
    left = (problem.contact_velocity(impulse)[:, 1:] * belts).sum(axis=1)
    caught = (speed > 0) & (left < speed**2 / 2)
    if caught.any() and residual(problem, impulse) <= SOLVED_RESIDUAL:
        places = ", ".join(f"({', '.join(f'{x:.4g}' for x in point)})" for point in contacts.point[caught])
        raise NoSolution(f"no bounded force prevents penetration of the contact sliding at {places}, at t = {time:.6g} s")


class Accelerations(NamedTuple):
    """The force problem with its answer in N, the contacts' accelerations (nc, 2), 0 along t at a sliding contact, and the
    largest acceleration of a contact without contact forces."""

    solved: Solved
    contacts: Array
    size: float


def accelerations(
    scene: Scene, q: Array, v: Array, time: float, contacts: Contacts, slip: NDArray[np.int64], solve: Solve
) -> Accelerations:
    """Solve for the accelerations. slip: (nc,), the direction of sliding of each contact, 0 if it sticks. Errors: NoSolution.

    A friction problem has no tangential bias. The tangential rates of sticking contacts are therefore included by a shift d of
    the accelerations with t'd = t.'v.
    """
    rate = rates(scene, q, v, contacts)
    held, d = slip == 0, np.zeros_like(v)
    if held.any():
        d = np.linalg.lstsq(contacts.tangent_rows.dense(len(v))[held], rate.tangent[held, 0], rcond=None)[0]
    problem = scene.friction_problem(
        q,
        scene.accelerate(q, scene.force(q, v, time)) + d,
        contacts,
        bias=rate.normal - contacts.normal @ d,
        joint_bias=rate.joint - scene.joints(q)[1] @ d,
    )
    size = float(np.abs(problem.q).max(initial=0.0))
    belts: Array = SWIFT * (size or 1.0) * slip[:, None].astype(float)
    if slip.any():
        chosen = np.flatnonzero(slip)
        problem = on_belts(problem, chosen, belts[chosen])
    impulse = solve(problem)
    require_moving_belts(problem, impulse, belts, contacts, time)
    u = problem.contact_velocity(impulse)
    u[~held, 1] = 0.0
    return Accelerations(Solved("forces", problem, impulse, contacts), u, size)
