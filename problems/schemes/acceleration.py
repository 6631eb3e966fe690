"""The scheme of forces and accelerations (Baraff 1993; Pfeiffer and Glocker 1996), whose equations may have no solution.

    M a = k + J' f + F' lam,      F a + F. v = 0,      v+ = v + h a,      q+ = q + h v+,
    0 <= n'a + n'. v ⟂ f_n >= 0,      f_t = -mu sign(t'v) f_n  where a contact slides,  |f_t| <= mu f_n where it does not,

at the contacts that touch at q; a dot is the rate along v, computed by finite differences. (The law is imposed on
n'v + h (n'a + n'. v), which is the same where n'v = 0, so that round-off in n'v does not grow; and a contact slides if one step
of the external force cannot stop it.) Where a touching contact approaches, an impact precedes the step
(problems.schemes.impact).

With the direction of sliding given a force need not exist: where Painlevé's rod slides with
p = n'M^-1 (n - mu sign(t'v) t) < 0, every f_n > 0 accelerates it downwards. Then NoSolution is raised.

The direction of sliding is imposed such that a friction problem remains for the solver: a sliding contact rests on a belt, an
additional body that moves in the direction of the slip, SWIFT times faster than all else. Friction does not depend on the speed
of the slip, so the forces are the same for every speed at which the belt continues to move. Where a correct answer stops a
belt, the forces are unbounded in the limit of fast belts, and the scheme has no solution.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.residual import residual
from frictionbench.problems.rows import Index64
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.impact import approaching, impact
from frictionbench.problems.schemes.stepping import NoSolution, Solve, Solved, Step, free_velocity, respond, scheme

SWIFT = 1e3  # the belts' speed, relative to the contacts' speeds and to the change by the external force in a step
RIGHT = 1e-6  # the residual up to which an answer is taken as the solution of the scheme's equations
NUDGE = 1e-5  # the displacement of the finite differences, relative to the largest body: balances round-off and curvature


@scheme("acceleration")
def acceleration(scene: Scene, now: Step, solve: Solve) -> Step:
    """One step of length scene.step. Errors: NoSolution where no force satisfies the law."""
    h, q, v = scene.step, now.q, now.v
    contacts = scene.contacts(q)
    solved: list[Solved] = []
    if approaching(scene, v, contacts).any():
        solved, v = impact(scene, q, v, contacts, solve)
    free = free_velocity(scene, now, v)
    normal_rate, joint_rate = _rates(scene, q, v, contacts)
    if (contacts.normal @ free + h * normal_rate >= 0).all():  # no force is a solution
        contacts, normal_rate = contacts.only(np.zeros(len(contacts), dtype=bool)), normal_rate[:0]
    problem = scene.friction_problem(q, free, contacts, bias=h * normal_rate, joint_bias=h * joint_rate)

    slip, push = (
        (contacts.tangent @ v).reshape(len(contacts), scene.dimension - 1),
        np.abs(problem.jacobian @ (free - v)).max(initial=0.0),
    )
    pace = np.linalg.norm(slip, axis=1)
    slides = pace > (1 + scene.coefficients(contacts)) * push + scene.touch / h
    along = slip[slides] / pace[slides, None]
    speed = SWIFT * (np.abs(problem.jacobian @ v).max(initial=0.0) + push)
    if slides.any():
        problem = _on_belts(problem, np.flatnonzero(slides), speed * along, scene.weights.max())
    step, after = respond("step", problem, solve)
    left = (problem.contact_velocity(step.impulse)[slides, 1:] * along).sum(axis=1)
    caught = np.flatnonzero(slides)[left < speed / 2]
    if len(caught) and residual(problem, step.impulse) <= RIGHT:
        places = ", ".join(f"({', '.join(f'{x:.4g}' for x in point)})" for point in contacts.point[caught])
        raise NoSolution(f"no bounded force prevents penetration of the contact sliding at {places}, at t = {now.time:.6g} s")
    after = after[: len(v)]
    return Step(now.time + h, scene.moved(q, h * after), after, contacts, (*solved, step))


def _on_belts(problem: FrictionProblem, contacts: Index64, velocities: Array, mass: float) -> FrictionProblem:
    """The problem with a belt of this velocity (n, d - 1) under each of these contacts (n,): d - 1 velocities more for each."""
    n = velocities.size
    nc, nj, tangents = problem.contacts, problem.joints.shape[0], velocities.shape[1]
    row = (tangents * contacts[:, None] + np.arange(tangents)).ravel()
    belt = sparse.csr_array((np.ones(n), (row, np.arange(n))), shape=(nc * tangents, n))
    return problem.replace(
        mass=sparse.block_diag([problem.mass, mass * sparse.eye_array(n)], format="csr"),
        normal=sparse.hstack([problem.normal, sparse.csr_array((nc, n))], format="csr"),
        tangent=sparse.hstack([problem.tangent, belt], format="csr"),
        joints=sparse.hstack([problem.joints, sparse.csr_array((nj, n))], format="csr"),
        free_velocity=np.concatenate([problem.free_velocity, velocities.ravel()]),
    )


def _rates(scene: Scene, q: Array, v: Array, contacts: Contacts) -> tuple[Array, Array]:
    """d/dt(n') v (nc,) and d/dt(F) v (nj,), by central differences along v; 0 at contacts that do not exist at both ends."""
    way = NUDGE * scene.geometry.reach
    fastest = np.abs(v).max(initial=0.0) * max(1.0, scene.geometry.reach)
    if not fastest or not (len(contacts) or scene.hinges):
        return np.zeros(len(contacts)), np.zeros(scene.joints(q)[1].shape[0])
    eps = way / fastest
    ahead, behind = scene.moved(q, eps * v), scene.moved(q, -eps * v)
    closing = [
        dict(zip(map(tuple, near.feature.tolist()), near.normal @ v, strict=True))
        for near in (scene.contacts(ahead, scene.touch + 10 * way), scene.contacts(behind, scene.touch + 10 * way))
    ]
    features = [tuple(feature) for feature in contacts.feature.tolist()]
    lasting = [closing[0][f] - closing[1][f] if f in closing[0] and f in closing[1] else 0.0 for f in features]
    joints = (scene.joints(ahead)[1] - scene.joints(behind)[1]) @ v
    return np.array(lasting) / (2 * eps), joints / (2 * eps)
