"""The motion of a scene as plain arrays (results.motion), with the impulses at its contacts and its energy balance.

A step takes v to v+ in one or more phases, each with M (v+ - v) = p + J'r + F'lam, where p is the external impulse. With the
mean velocity w = (v + v+)/2 the kinetic energy changes by exactly

    p'w + r'J w + lam'F w:      external force, contacts (tangential and normal separately), hinges.
"""

from functools import partial
from itertools import pairwise

import numpy as np

from frictionbench.harness.cells.simulation import DIVERGED, energy_scale, usable
from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import scenes
from frictionbench.problems.check import Array
from frictionbench.problems.generalised import GeneralisedScene
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.residual import residual
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES, NoSolution, Step
from frictionbench.problems.simulate import simulate
from frictionbench.problems.spatial.bodies import SpatialGeometry, Sphere
from frictionbench.problems.spatial.collision import CORNERS
from frictionbench.problems.spatial.rotation import frames
from frictionbench.results.conventions import DEFAULT_SCHEME
from frictionbench.results.motion import Motion, Outline
from frictionbench.solvers import solve

TOLERANCE = 1e-8  # as in the suites' simulations


def record_motion(stage: Scene, solver: str, scheme: str = DEFAULT_SCHEME, steps: int | None = None) -> Motion:
    """Record the motion of a scene with a solver. It ends early if the scheme has no solution, the solver gives no usable
    answer, or the energy diverges.

    Errors: InputError if the solver cannot be used or the scheme refuses the scene.
    """
    taken: list[Step] = []
    ended, start = "", stage.energy(stage.q0, stage.v0)
    most = DIVERGED * energy_scale(stage, [start], [stage.kinetic(stage.q0, stage.v0)])
    try:
        for step in simulate(stage, partial(_answered, solver=solver), SCHEMES[scheme], steps):
            if not abs(stage.energy(step.q, step.v) - start) <= most:
                ended = f"diverged in step {len(taken)}"
                break
            taken.append(step)
    except (NoSolution, _NoAnswer) as finding:
        ended = str(finding)
    parts = [_balance(stage, before, after) for before, after in pairwise(taken)]
    work = np.cumsum([np.zeros(3), *(work for _, work, _ in parts)], axis=0)
    general = stage if isinstance(stage, GeneralisedScene) else None
    defaults = scenes()[stage.name].parameters if stage.name in scenes() else {}
    return Motion(
        scene=stage.name,
        parameters=stage.parameters,
        changed={name: value for name, value in stage.parameters.items() if name not in defaults or value != defaults[name]},
        solver=solver,
        scheme=scheme,
        step=stage.step,
        coefficient=stage.friction,
        restitution=stage.restitution,
        ended=ended,
        outlines=_outlines(stage),
        hinges=_pins(stage),
        times=np.array([step.time for step in taken]),
        poses=np.array([general.poses(step.q) if general else step.q.reshape(len(stage.bodies), -1) for step in taken]),
        contacts=(*(contacts for contacts, _, _ in parts), np.zeros((0, 3 * stage.dimension))),
        energy=np.array([stage.energy(step.q, step.v) for step in taken]),
        kinetic=np.array([stage.kinetic(step.q, step.v) for step in taken]),
        friction=work[:, 0],
        normal=work[:, 1],
        joints=work[:, 2],
        residual=np.array([*(worst for _, _, worst in parts), 0.0]),
    )


class _NoAnswer(Exception):  # noqa: N818  # no error but a result about the solver, which ends the motion
    pass


def _answered(problem: FrictionProblem, solver: str) -> Array:
    answer = solve(problem, solver, tol=TOLERANCE)
    if (impulse := usable(problem, answer.impulse)) is None:
        raise _NoAnswer(f"{solver} returned no usable answer: {answer.detail or answer.status.value}")
    return impulse


def _balance(stage: Scene, before: Step, after: Step) -> tuple[Array, Array, float]:
    """Return a step's contacts (nc, 3 d) as in results.motion, the work (3,) of friction, normal impulses and hinges, and the
    largest residual of its answers."""
    nv, d, v, work, worst = len(before.v), stage.dimension, before.v, np.zeros(3), 0.0
    contacts = [np.zeros((0, 3 * d))]
    for smooth in after.smooth:
        work[0] += smooth.work
        contacts.append(_placed(smooth.contacts, smooth.impulse))
    for phase, problem, impulse, contacts_of_phase, returned in after.solved:
        worst = max(worst, residual(problem, impulse))
        if phase == "forces":  # its work is counted in the smooth motion
            continue
        if phase in ("impact", "compression"):  # at a time within the step
            v = problem.free_velocity
        J, total = problem.jacobian[:, :nv], impulse.copy()  # a scheme may append velocities to the scene's
        after_phase = problem.velocity(impulse)[:nv]
        hinge_impulse = problem.mass[:nv, :nv] @ (after_phase - problem.free_velocity[:nv]) - J.T @ impulse.ravel()
        total[:, 0] += returned  # Poisson's impulse, which is applied before the problem of the decompression
        middle = (v + after_phase) / 2
        normal, *tangential = (total * (J @ middle).reshape(-1, d)).sum(axis=0)
        work += sum(tangential), normal, hinge_impulse @ middle
        contacts.append(_placed(contacts_of_phase, total))
        v = after_phase
    return _merged(np.vstack(contacts)), work, worst


def _placed(contacts: Contacts, impulse: Array) -> Array:
    """Return the contacts (nc, 3 d) as in results.motion. A normal between two bodies is turned to point upwards; in the plane
    the impulse's components along the normal and the tangent do not change."""
    direction = contacts.direction
    sign = np.where((contacts.bodies >= 0).all(axis=1) & (direction[:, -1] < 0), -1.0, 1.0)[:, None]
    drawn = sign * np.einsum("ck,cka->ca", impulse, frames(direction)) if impulse.shape[1] == 3 else impulse
    return np.column_stack([contacts.point, sign * direction, drawn])


def _merged(contacts: Array) -> Array:
    """Return the contacts of all phases of a step, with the impulses at one place summed.

    All phases detect contacts at the same positions, so that the places of a contact are equal to the last bit.
    """
    d = contacts.shape[1] // 3
    place, which = np.unique(contacts[:, : 2 * d], axis=0, return_inverse=True)
    impulse = np.zeros((len(place), d))
    np.add.at(impulse, which.reshape(-1), contacts[:, 2 * d :])
    return np.column_stack([place, impulse])


def _outlines(stage: Scene) -> tuple[Outline, ...]:
    """Return the outlines of all shapes; a body without shapes is drawn as a rod between its hinges."""
    if isinstance(stage, GeneralisedScene):
        return tuple(Outline(i, s.corners, s.radius, s.endless) for i, s in stage.outlines)
    if isinstance(stage.geometry, SpatialGeometry):
        return _solids(stage.geometry)
    shapes = [(i, shape) for i, body in enumerate(stage.geometry.bodies) for shape in body.shapes]
    drawn = [Outline(i, s.corners, s.radius, s.endless) for i, s in [*shapes, *((-1, s) for s in stage.geometry.obstacles)]]
    pins = _pins(stage)
    for i, body in enumerate(stage.geometry.bodies):
        if not body.shapes:
            drawn.append(Outline(i, np.vstack([pins[pins[:, 0] == i][:2, 1:], np.zeros((2, 2))])[:2], 0.0, False))
    return tuple(drawn)


def _solids(geometry: SpatialGeometry) -> tuple[Outline, ...]:
    """Return the outlines of spheres, boxes and half spaces."""
    shapes = [body.shape for body in geometry.bodies]
    drawn = [
        Outline(i, np.zeros((1, 3)), s.radius, False) if isinstance(s, Sphere) else Outline(i, CORNERS * s.half, 0.0, False)
        for i, s in enumerate(shapes)
    ]
    planes = [Outline(-1, np.stack([o.height * o.normal, o.normal]), 0.0, True) for o in geometry.obstacles]
    return (*drawn, *planes)


def _pins(stage: Scene) -> Array:
    """Return an array (pins, 3): for each body of each hinge, the body's index and the hinge's position in its frame."""
    ends = [(i, *point) for hinge in stage.hinges for i, point in zip(hinge.bodies, hinge.points, strict=True)]
    return np.array(ends, dtype=float).reshape(-1, 3)
