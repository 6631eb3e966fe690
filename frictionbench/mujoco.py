"""Steps of MuJoCo's models with contacts, limits, dry friction and equalities solved exactly.

>>> import frictionbench as fb
>>> result = fb.mujoco.step(model, data)  # doctest: +SKIP

in place of mujoco.mj_step(model, data); in a loop `step(model, data, before=result)` starts from the impulses of the step
before.

Positions, collisions, actuators, passive and applied forces are MuJoCo's, and so is the velocity v* that it would reach without
constraints (problems.capture.mujoco). The step is that of Anitescu and Potra (1997), after Stewart and Trinkle (1996):

    A (v+ - v*) = J' r + F' lam,    F v+ = 0,    Coulomb's law between r and J v+ + b,    b = max(gap, 0) / h,    q+ = q + h v+,

with limits and dry friction as rows of J. As b >= 0 and the joints ask for nothing else than rest, v+ = 0 satisfies all that is
asked of velocities, whatever overlaps: the step has a solution. (MuJoCo lists contacts and limits within their margin alone,
most often those that have begun to penetrate.)

Penetrations and errors of joints are taken away from positions, not by velocities, so that they add no momentum. A depth of
SLOP of the model's mean size is left, so that MuJoCo lists resting contacts in every step: else a contact that a solver's
tolerance opens by a nanometre is lost for a step. With the depths d beyond it that the step leaves by its linear forecast, the
rows A_i of the normals, limits and equalities, W = A_i A^-1 A_i',

    min 1/2 x'(W + E) x - SHARE d'x,    x_i >= 0 for normals and limits,    delta = A^-1 A_i' x,    q+ += delta,

E = SOFT diag(W): each row alone is moved by nearly SHARE of its depth a step, and rows that contradict each other, as of parts
that are wedged, by a compromise. The program is strictly convex, and always has its solution.

Not in the step: torsional and rolling friction, the softness of constraints, adhesion by contacts, restitution.
"""

from collections import defaultdict
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import count as numbered
from time import thread_time
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.optimize import nnls

from frictionbench.problems import FrictionProblem, InputError, Status
from frictionbench.problems.capture import mujoco as engine
from frictionbench.problems.capture.parts import Contacts, posed, require_finite, without_noise
from frictionbench.problems.check import Array
from frictionbench.problems.residual import residual
from frictionbench.problems.simulate import ledger_defect
from frictionbench.solvers import solve

SHARE = 0.2  # of a penetration, taken away in a step
SOFT = 1e-3  # of the diagonal
SLOP = 1e-3


@dataclass(frozen=True, eq=False)
class Step:
    """A step that was taken.

    problem, impulse (nc, 3) in N s, the normal first: contacts in the order of data.contact, then limits, then dry friction.
    status: the solver's. seconds: processor's time of its call. penetration: m or rad, the deepest with which the step began.
    energy: in J, what changed the kinetic energy ("kinetic"): work of "forces" (with damping), "contacts" by their normals,
    "friction", "limits", "dry friction" and "equalities", each with the mean of the velocities before and after, so that they
    add up to it; "correction", the work against the forces when positions are corrected; "defect", the energy that the answer
    adds compared with an exact one.
    """

    problem: FrictionProblem
    impulse: Array
    status: Status
    seconds: float
    penetration: float
    energy: Mapping[str, float]
    memory: Mapping[Hashable, Array]

    @cached_property
    def residual(self) -> float:
        """The residual of Coulomb's law, as of `frictionbench.residual`."""
        return residual(self.problem, self.impulse)

    def __repr__(self) -> str:
        return f"Step({self.problem.summary}, {self.status.value})"


class _Kinds(NamedTuple):
    """Which of data.contact have rows, and which of MuJoCo's rows (nefc,) are limits, dry friction and equations."""

    touching: Array
    limit: Array
    dry: Array
    equal: Array


@dataclass(frozen=True, eq=False)
class _Stage:
    """What MuJoCo computes before the solver's turn: its rows, the masses A as they are and symmetric, the velocity v*."""

    contacts: Contacts
    J: Array
    kinds: _Kinds
    full: Array
    mass: Array
    free: Array


def problem(model: Any, data: Any) -> FrictionProblem:
    """The friction problem of the step that `step` would take from here.

    model, data: as of `step`. Of data, what mujoco.mj_forward computes is set, but for the forces of constraints.
    Errors: as of `step`.
    """
    import mujoco as mj

    return _problem(model, _stage(mj, model, data))


def step(
    model: Any, data: Any, solver: str = "hybrid", tol: float = 1e-8, before: Step | None = None, limit: int | None = None
) -> Step:
    """Advance data by one step, in place of mujoco.mj_step(model, data).

    model: a mujoco.MjModel. Its integrator decides how damping enters: Euler or implicitfast as they are, implicit with the
    symmetric part of its mass; RK4, whose stages have no impulses of their own, as Euler. data: a mujoco.MjData with controls
    and applied forces; afterwards it holds what mj_step leaves, with the forces of constraints and the sensors of this step.
    solver, tol, limit: as of `frictionbench.solve`; a solver of the convex relaxation makes a step by that law.
    before: the step before, for a warm start by pairs of geoms and by joints.

    Where the solver fails, its status says so, and its impulses are used as they are, or none where they are not finite.
    Errors: InputError naming data where the simulation has diverged, contact where its surface moves, dof_dampingpoly where
    Euler is given damping that is not linear, or what `solve` refuses.
    """
    import mujoco as mj

    stage = _stage(mj, model, data)
    posed_problem = _problem(model, stage)
    keys, frames = _keys(data, stage.kinds), _frames(data, stage.kinds)
    guess = None if before is None else _guess(before, keys, frames)
    begin = thread_time()
    answer = solve(posed_problem, solver, tol=tol, start=guess, limit=limit)
    seconds = thread_time() - begin
    impulse = answer.impulse if np.isfinite(answer.impulse).all() else np.zeros_like(answer.impulse)
    velocity = posed_problem.velocity(impulse)
    energy = _energy(mj, model, data, stage, impulse, velocity) | {"defect": ledger_defect(posed_problem, impulse)}
    delta = _correction(model, data, stage, velocity)
    energy["correction"] = -float(delta @ data.qfrc_smooth)
    _advance(mj, model, data, stage, impulse, velocity)
    mj.mj_integratePos(model, data.qpos, delta, 1.0)
    depth = float(-stage.contacts.gap.min(initial=0.0)) + 0.0
    memory = dict(zip(keys, np.einsum("kji,kj->ki", frames, impulse), strict=True))
    return Step(posed_problem, impulse, answer.status, seconds, depth, energy, memory)


def start(model: Any, data: Any, before: Step) -> Array:
    """The impulses (nc, 3) of the step before, for the contacts that it had too, to start from; zero for others.

    model, data: as after `problem`, whose contacts these are.
    """
    import mujoco as mj

    kinds = _kinds(mj, data)
    return _guess(before, _keys(data, kinds), _frames(data, kinds))


def _guess(before: Step, keys: list[Hashable], frames: Array) -> Array:
    """The impulses (nc, 3) of the step before, in the frames of these rows; zero for rows that it had not."""
    old = np.array([before.memory.get(key, np.zeros(3)) for key in keys]).reshape(-1, 3)
    return np.einsum("kij,kj->ki", frames, old)


def steps(model: Any, data: Any, count: int, solver: str = "hybrid", tol: float = 1e-8) -> Iterator[Step]:
    """So many steps, each started from the one before; between them the caller may set controls. Errors: as of `step`."""
    before = None
    for _ in range(count):
        before = step(model, data, solver, tol, before)
        yield before


def _stage(mj: Any, model: Any, data: Any) -> _Stage:
    implicit = model.opt.integrator in engine.known(mj)[1:]
    if not implicit and np.any(model.dof_dampingpoly):
        raise InputError("dof_dampingpoly: Euler takes damping as linear; use implicitfast")
    mj.mj_step1(model, data)
    mj.mj_fwdActuation(model, data)
    mj.mj_fwdAcceleration(model, data)
    require_finite(data.qpos, data.qvel, data.qfrc_smooth)
    if implicit:  # a trial step, for the derivatives of forces
        everything = mj.mjtState.mjSTATE_INTEGRATION
        state = np.empty(mj.mj_stateSize(model, everything))
        mj.mj_getState(model, data, state, everything)
        data.qfrc_constraint[:] = 0
        mj.mj_implicit(model, data)
        mj.mj_setState(model, data, state, everything)
    full = engine.mass_of(mj, model, data)
    require_finite(full)
    mass = without_noise(full)
    J = engine.jacobian(mj, model, data)
    contacts, _ = engine.rows_of(mj, model, data, J)
    free = data.qvel + model.opt.timestep * np.linalg.solve(full, data.qfrc_smooth)
    return _Stage(contacts, J, _kinds(mj, data), full, mass, free)


def _kinds(mj: Any, data: Any) -> _Kinds:
    equal = data.efc_type == int(mj.mjtConstraint.mjCNSTR_EQUALITY)
    return _Kinds(data.contact.efc_address >= 0, *engine.limits_and_dry_friction(mj, data), equal)


def _problem(model: Any, stage: _Stage) -> FrictionProblem:
    F = stage.J[stage.kinds.equal]
    bias = np.maximum(stage.contacts.gap, 0.0) / model.opt.timestep
    return posed(stage.mass, stage.free, stage.contacts, bias, F, np.zeros(len(F)))


def _frames(data: Any, kinds: _Kinds) -> Array:
    """(nc, 3, 3): of contacts the frame that the impulses are told in, by rows; for rows of joints the unit matrix."""
    frames = np.tile(np.eye(3), (sum(rows.sum() for rows in kinds[:3]), 1, 1))
    frames[: kinds.touching.sum()] = data.contact.frame[kinds.touching].reshape(-1, 3, 3)
    return frames


def _keys(data: Any, kinds: _Kinds) -> list[Hashable]:
    """What is the same row in the next step: the geoms of a contact, the joint of a limit, and the how manieth of them."""
    at = data.contact
    pairs = np.column_stack([at.geom, at.flex, at.elem, at.vert])[kinds.touching]
    bases: list[Hashable] = [("contact", *pair) for pair in pairs.tolist()]
    for rows in (kinds.limit, kinds.dry):
        bases += [(int(data.efc_type[i]), int(data.efc_id[i])) for i in np.flatnonzero(rows)]
    numbers = defaultdict[Hashable, Iterator[int]](numbered)  # of equal ones
    return [(base, next(numbers[base])) for base in bases]


def _energy(mj: Any, model: Any, data: Any, stage: _Stage, impulse: Array, velocity: Array) -> dict[str, float]:
    """The ledger of Step, but for defect and correction."""
    M = np.zeros_like(stage.mass)
    mj.mj_fullM(model, data, M)
    change, mean = velocity - data.qvel, (velocity + data.qvel) / 2
    total = stage.full @ (velocity - stage.free)
    forces = model.opt.timestep * data.qfrc_smooth - (stage.full - M) @ change
    work = impulse * (stage.contacts.rows @ mean).reshape(-1, 3)
    touching = stage.kinds.touching.sum()
    middle = touching + stage.kinds.limit.sum()
    return {
        "kinetic": float(mean @ M @ change),
        "forces": float(mean @ forces),
        "contacts": float(work[:touching, 0].sum()),
        "friction": float(work[:touching, 1:].sum()),
        "limits": float(work[touching:middle].sum()),
        "dry friction": float(work[middle:].sum()),
        "equalities": float(mean @ total - work.sum()),
    }


def _correction(model: Any, data: Any, stage: _Stage, velocity: Array) -> Array:
    """delta (nv,): see above."""
    normal = stage.contacts.rows.reshape(-1, 3, len(velocity))[:, 0]
    depth = -(stage.contacts.gap + model.opt.timestep * normal @ velocity) - SLOP * model.stat.meansize
    deep = (stage.contacts.gap < 0) & (depth > 0)
    F, error = stage.J[stage.kinds.equal], data.efc_pos[stage.kinds.equal]
    if not deep.any() and not error.any():
        return np.zeros_like(velocity)
    rows, wanted = np.vstack([normal[deep], F, -F]), SHARE * np.concatenate([depth[deep], -error, error])
    moved = cho_solve(cho_factor(stage.mass), rows.T)
    W = rows @ moved
    root = cholesky(W + np.diag(SOFT * np.maximum(np.diag(W), np.finfo(float).tiny)))
    x, _ = nnls(root, solve_triangular(root, wanted, trans="T"))
    return moved @ x


def _advance(mj: Any, model: Any, data: Any, stage: _Stage, impulse: Array, velocity: Array) -> None:
    """Let MuJoCo integrate activations, velocities and positions, with forces that make its next velocity this one."""
    h = model.opt.timestep
    data.efc_force[:] = _forces(mj, data, stage, impulse, stage.full @ (velocity - stage.free)) / h
    data.qfrc_constraint[:] = stage.full @ (velocity - stage.free) / h
    data.qacc[:] = (velocity - data.qvel) / h
    mj.mj_sensorAcc(model, data)
    (mj.mj_implicit if model.opt.integrator in engine.known(mj)[1:] else mj.mj_Euler)(model, data)


def _forces(mj: Any, data: Any, stage: _Stage, impulse: Array, total: Array) -> Array:
    """The impulses of MuJoCo's own rows (nefc,)."""
    result, at, pyramid = np.zeros(len(stage.J)), data.contact, int(mj.mjtConstraint.mjCNSTR_CONTACT_PYRAMIDAL)
    touching = np.flatnonzero(stage.kinds.touching)
    for i, k in enumerate(touching):
        first, dim, friction = at.efc_address[k], at.dim[k], at.friction[k]
        force = np.zeros(dim)
        force[:3] = impulse[i, : min(dim, 3)]
        if dim > 1:
            force[2] *= friction[1] / friction[0]
        if dim > 1 and data.efc_type[first] == pyramid:
            along = force[1:] / friction[: dim - 1]  # edges may pull: the cone is wider than the pyramid
            force = np.stack([force[0] / (dim - 1) + along, force[0] / (dim - 1) - along], axis=1).ravel() / 2
        result[first : first + len(force)] = force
    middle = len(touching) + stage.kinds.limit.sum()
    result[stage.kinds.limit], result[stage.kinds.dry] = impulse[len(touching) : middle, 0], impulse[middle:, 1]
    if stage.kinds.equal.any():
        result[stage.kinds.equal] = np.linalg.lstsq(
            stage.J[stage.kinds.equal].T, total - stage.contacts.rows.T @ impulse.ravel(), rcond=None
        )[0]
    return result
