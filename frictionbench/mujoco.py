"""Steps of MuJoCo's models with contacts, limits, dry friction and equalities solved exactly.

>>> import frictionbench as fb
>>> result = fb.mujoco.step(model, data)  # doctest: +SKIP

replaces mujoco.mj_step(model, data); in a loop, `step(model, data, before=result)` is warm-started from the previous step.

MuJoCo computes positions, collisions, actuation, passive and applied forces, and the velocity v* that it would reach without
constraints (problems.capture.mujoco). The step is that of Anitescu and Potra (1997), after Stewart and Trinkle (1996):

    A (v+ - v*) = J' r + F' lam,    F v+ = 0,    Coulomb's law between r and J v+ + b,    b = max(gap, 0) / h,    q+ = q + h v+,

with limits and dry friction as rows of J. As b >= 0 and the equalities have no right-hand side, v+ = 0 satisfies all
constraints on the velocity, however deep the penetrations are: with polygons as friction cones the step has a solution.

Penetrations and errors of equalities are corrected in the positions, not by velocities, so that this adds no momentum. A depth
of SLOP times the model's mean size is left, so that MuJoCo lists resting contacts in every step: otherwise a contact
that the solver's tolerance opens by a nanometre would be missing in the next step. Let d be the depths beyond it that are
predicted, linearly, for the end of the step, A_i the rows of normals, limits and equalities, and W = A_i A^-1 A_i':

    min 1/2 x'(W + E) x - CORRECTED_SHARE d'x,    x_i >= 0 for normals and limits,    delta = A^-1 A_i' x,    q+ += delta,

with E = SOFT diag(W). A single row is corrected by nearly CORRECTED_SHARE of its depth in each step; the regularisation gives a
compromise where rows contradict each other, as those of wedged parts do, and a solution in all cases.

The step has no torsional or rolling friction, soft constraints or restitution. Adhesion acts as an applied force.
"""

from collections import defaultdict
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import count as numbered
from time import thread_time
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, qr, solve_triangular
from scipy.optimize import nnls

from frictionbench.problems import FrictionProblem, Status
from frictionbench.problems.capture import mujoco as engine
from frictionbench.problems.capture.mujoco import Kinds
from frictionbench.problems.capture.parts import Contacts, posed, require_finite, without_noise
from frictionbench.problems.check import Array, require
from frictionbench.problems.residual import residual
from frictionbench.problems.verify import ledger_defect
from frictionbench.solvers import solve

CORRECTED_SHARE = 0.2  # of a penetration, corrected in one step
SOFT = 1e-3  # regularisation relative to diag(W)
SLOP = 1e-3  # depth that is left, relative to model.stat.meansize
IMPLIED = 1e-4  # of an equality's row, scaled, that is not a combination of others: below, the loops that they close imply it
EQUALITY_ROUNDING = 1e-10  # relative to the largest: smaller rows and columns of equalities are rounding errors


@dataclass(frozen=True, eq=False)
class Step:
    """The result of one step.

    problem, impulse (nc, 3) in N s, the normal first: contacts in the order of data.contact, then limits, then dry friction.
    status: the solver's. seconds: CPU time of the solver's call. penetration: m or rad, the deepest at the start of the step.
    energy: in J. "kinetic" is the change of the kinetic energy. It is the sum of the works of "forces" (with damping),
    "contacts" (normal impulses), "friction", "limits", "dry friction" and "equalities", each computed with the mean of the
    velocities before and after the step. "correction" is the work against the forces done by the correction of positions;
    "defect" is the energy that the solver's error adds.
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


class _Stage(NamedTuple):
    """What MuJoCo computes before the problem is solved: rows, v* as `free`, A as `full`, its symmetric part as `mass`."""

    contacts: Contacts
    J: Array
    kinds: Kinds
    full: Array
    mass: Array
    free: Array


def problem(model: Any, data: Any) -> FrictionProblem:
    """The friction problem of the step that `step` would take from here.

    model, data: as of `step`. All that mujoco.mj_forward computes is set in data, except for the forces of constraints.
    Errors: as of `step`.
    """
    import mujoco as mj

    return _problem(model, _stage(mj, model, data))


def step(
    model: Any, data: Any, solver: str = "hybrid", tol: float = 1e-8, before: Step | None = None, limit: int | None = None
) -> Step:
    """Advance data by one step, in place of mujoco.mj_step(model, data).

    model: a mujoco.MjModel. Its integrator determines the treatment of damping: Euler is used unchanged, implicitfast without
    the gyroscopic terms of single free bodies, implicit with the symmetric part of its mass matrix; RK4 is replaced by Euler.
    data: a mujoco.MjData with controls and applied forces; then as mj_step leaves it, with this step's forces and sensors.
    solver, tol, limit: as of `frictionbench.solve`; a solver of the convex relaxation steps with that law.
    before: the previous step, for a warm start by pairs of geoms and by joints.

    If the solver fails, `status` says so, and its impulses are used nevertheless, or zero if they are not finite.
    Errors: InputError naming model without joints, data of another model or where the simulation has diverged, contact where
    its surface moves, dof_dampingpoly where Euler has nonlinear damping, integrator where it is unknown or implicit's mass is
    indefinite, or what `solve` refuses.
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
    """The impulses (nc, 3) of the previous step for contacts that it had too, as a warm start; zero for new contacts.

    model, data: as after `problem`, whose contacts these are.
    """
    import mujoco as mj

    kinds = engine.kinds_of(mj, data)
    return _guess(before, _keys(data, kinds), _frames(data, kinds))


def _guess(before: Step, keys: list[Hashable], frames: Array) -> Array:
    """The impulses (nc, 3) of the previous step in the frames of these rows; zero for new rows."""
    old = np.array([before.memory.get(key, np.zeros(3)) for key in keys]).reshape(-1, 3)
    return np.einsum("kij,kj->ki", frames, old)


def steps(model: Any, data: Any, count: int, solver: str = "hybrid", tol: float = 1e-8) -> Iterator[Step]:
    """Take `count` steps, each warm-started; the caller may set controls between them. Errors: as of `step`."""
    before = None
    for _ in range(count):
        before = step(model, data, solver, tol, before)
        yield before


def _stage(mj: Any, model: Any, data: Any) -> _Stage:
    engine.require_usable(mj, model, data)
    implicit = model.opt.integrator in engine.known(mj)[1:]
    usable = model.opt.integrator in (*engine.known(mj), mj.mjtIntegrator.mjINT_RK4)
    require(usable, "integrator", "must be Euler, RK4, implicit or implicitfast")
    require(implicit or not model.dof_dampingpoly.any(), "dof_dampingpoly", "Euler takes damping as linear; use implicitfast")
    mj.mj_step1(model, data)
    mj.mj_fwdActuation(model, data)
    mj.mj_fwdAcceleration(model, data)
    require_finite(data.qfrc_smooth)
    if implicit:  # a trial step computes the derivatives of forces
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
    kinds = engine.kinds_of(mj, data)
    contacts, _ = engine.rows_of(mj, model, data, J, kinds)
    free = data.qvel + model.opt.timestep * np.linalg.solve(full, data.qfrc_smooth)
    free[(data.tree_asleep >= 0)[model.dof_treeid]] = 0.0  # no force acts on what MuJoCo has put to sleep
    return _Stage(contacts, J, kinds, full, mass, free)


def _problem(model: Any, stage: _Stage) -> FrictionProblem:
    F = _independent(stage.J[stage.kinds.equal])
    bias = np.maximum(stage.contacts.gap, 0.0) / model.opt.timestep
    return posed(stage.mass, stage.free, stage.contacts, bias, F, np.zeros(len(F)))


def _independent(F: Array) -> Array:
    """The equalities F (nj, nv) without those that others imply: in a loop that is out of place by an error, as after any step,
    these differ from the others by an angle, and would forbid what the loop allows."""
    if not F.any():
        return F
    scaled = F / np.maximum(np.abs(F).max(axis=0), EQUALITY_ROUNDING * np.abs(F).max())  # metres and radians
    size = np.linalg.norm(scaled, axis=1)
    triangle, order = qr((scaled / np.maximum(size, EQUALITY_ROUNDING * size.max())[:, None]).T, mode="r", pivoting=True)
    independent = np.abs(np.diag(triangle)) > IMPLIED
    return np.array(F[np.sort(order[: len(independent)][independent])])


def _frames(data: Any, kinds: Kinds) -> Array:
    """(nc, 3, 3): the rows are the axes of each contact's impulse; the unit matrix for limits and dry friction."""
    frames = np.tile(np.eye(3), (sum(rows.sum() for rows in kinds[:3]), 1, 1))
    frames[: kinds.touching.sum()] = data.contact.frame[kinds.touching].reshape(-1, 3, 3)
    return frames


def _keys(data: Any, kinds: Kinds) -> list[Hashable]:
    """What identifies a row from step to step: a contact's geoms or a limit's joint, and its number among equal ones."""
    at = data.contact
    pairs = np.column_stack([at.geom, at.flex, at.elem, at.vert])[kinds.touching]
    bases: list[Hashable] = [("contact", *pair) for pair in pairs.tolist()]
    for rows in (kinds.limit, kinds.dry):
        bases += [(int(data.efc_type[i]), int(data.efc_id[i])) for i in np.flatnonzero(rows)]
    numbers = defaultdict[Hashable, Iterator[int]](numbered)
    return [(base, next(numbers[base])) for base in bases]


def _energy(mj: Any, model: Any, data: Any, stage: _Stage, impulse: Array, velocity: Array) -> dict[str, float]:
    """The energies of Step, except for defect and correction."""
    M = np.zeros_like(stage.mass)
    mj.mj_fullM(model, data, M)
    change, mean = velocity - data.qvel, (velocity + data.qvel) / 2
    total = stage.mass @ (velocity - stage.free)
    work = impulse * (stage.contacts.rows @ mean).reshape(-1, 3)
    touching = stage.kinds.touching.sum()
    middle = touching + stage.kinds.limit.sum()
    return {
        "kinetic": float(mean @ M @ change),
        "forces": float(mean @ (M @ change - total)),
        "contacts": float(work[:touching, 0].sum()),
        "friction": float(work[:touching, 1:].sum()),
        "limits": float(work[touching:middle].sum()),
        "dry friction": float(work[middle:].sum()),
        "equalities": float(mean @ total - work.sum()),
    }


def _correction(model: Any, data: Any, stage: _Stage, velocity: Array) -> Array:
    """delta (nv,), the correction of positions that the module's docstring defines."""
    normal = stage.contacts.rows.reshape(-1, 3, len(velocity))[:, 0]
    depth = -(stage.contacts.gap + model.opt.timestep * normal @ velocity) - SLOP * model.stat.meansize
    deep = (stage.contacts.gap < 0) & (depth > 0)
    F, error = stage.J[stage.kinds.equal], data.efc_pos[stage.kinds.equal]
    if not deep.any() and not error.any():
        return np.zeros_like(velocity)
    rows, wanted = np.vstack([normal[deep], F, -F]), CORRECTED_SHARE * np.concatenate([depth[deep], -error, error])
    moved = cho_solve(cho_factor(stage.mass), rows.T)
    W = rows @ moved
    size = np.diag(W)
    # Nothing moves a wheel aside from its own car: of such rows only rounding acts, and they ask for nothing.
    root = cholesky(W + np.diag(np.where(size > np.finfo(float).eps * size.max(), SOFT * size, 1.0)))
    x, _ = nnls(root, solve_triangular(root, wanted, trans="T"))
    return moved @ x


def _advance(mj: Any, model: Any, data: Any, stage: _Stage, impulse: Array, velocity: Array) -> None:
    """Let MuJoCo integrate activations, velocities and positions with the constraint forces that give this velocity."""
    h = model.opt.timestep
    data.efc_force[:] = _forces(mj, data, stage, impulse, stage.mass @ (velocity - stage.free)) / h
    data.qfrc_constraint[:] = stage.full @ (velocity - stage.free) / h
    data.qacc[:] = (velocity - data.qvel) / h
    mj.mj_sensorAcc(model, data)
    position = data.qpos.copy()
    (mj.mj_implicit if model.opt.integrator in engine.known(mj)[1:] else mj.mj_Euler)(model, data)
    # implicitfast adds gyroscopic terms for free bodies, so that its velocity is not the one that was solved for.
    data.qvel[:] = np.where((data.tree_asleep >= 0)[model.dof_treeid], 0.0, velocity)
    data.qpos[:] = position
    mj.mj_integratePos(model, data.qpos, data.qvel, h)


def _forces(mj: Any, data: Any, stage: _Stage, impulse: Array, total: Array) -> Array:
    """The impulses in terms of MuJoCo's rows (nefc,)."""
    result, at, pyramid = np.zeros(len(stage.J)), data.contact, int(mj.mjtConstraint.mjCNSTR_CONTACT_PYRAMIDAL)
    touching = np.flatnonzero(stage.kinds.touching)
    for i, k in enumerate(touching):
        first, dim, friction = at.efc_address[k], at.dim[k], at.friction[k]
        force = np.zeros(dim)
        force[:3] = impulse[i, : min(dim, 3)]
        if dim > 1:
            force[1:3] *= friction[:2] / friction[:2].max()
        if dim > 1 and data.efc_type[first] == pyramid:
            along = force[1:] / friction[: dim - 1]  # edges may pull: the cone is wider than the pyramid
            force = np.stack([force[0] / (dim - 1) + along, force[0] / (dim - 1) - along], axis=1).ravel() / 2
        result[first : first + len(force)] = force
    middle = len(touching) + stage.kinds.limit.sum()
    result[stage.kinds.limit], result[stage.kinds.dry] = impulse[len(touching) : middle, 0], impulse[middle:, 1]
    if stage.kinds.equal.any():
        rest = total - stage.contacts.rows.T @ impulse.ravel()
        result[stage.kinds.equal] = np.linalg.lstsq(stage.J[stage.kinds.equal].T, rest, rcond=None)[0]
    return result
