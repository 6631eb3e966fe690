"""A step of MuJoCo as a friction problem.

mj_step itself takes the step on a copy of the data. Let tau be the forces of gravity, springs, damping, actuators and the user,
B the damping of the joints, and D = d tau / d v. Without constraints, MuJoCo's integrators change the velocity v to

    v* = v + h A^-1 tau,      Euler  A = M + h B,      implicitfast  A = M - h D,      implicit  the same, D not symmetric.

A is also the mass matrix for impulses; if D is not symmetric, the symmetric part of A is used. Each contact has rows J of
MuJoCo's constraints in its frame, normal first:

    elliptic    J_n, J_1, J_2, ... themselves, forces f_n, f_1, f_2, ...
    pyramidal   edges J_n +- mu_k J_k, forces a_k+-:     f_n = sum a,  f_k = mu_k (a_k+ - a_k-)

Friction with two coefficients is friction with the larger one, mu, if the row of tangent k is multiplied by mu_k/mu and its
impulse by mu/mu_k. Limits and dry friction of joints and tendons are contacts of the problem (see FrictionProblem).
Sources: MuJoCo's documentation, "Computation", sections on the constraint model and on integrators; mju_decodePyramid.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems.capture.parts import Contacts, Step, captured, require_finite, share_of_softness
from frictionbench.problems.check import Array, require
from frictionbench.problems.recorded.native import EngineStep

Mask = NDArray[np.bool_]
TORSION, ROLLING = 3, 4  # the first rows of a contact for torsional friction and for rolling friction
GAP_ROUNDING = 8 * np.finfo(float).eps  # of the distances and radii of which a gap is the difference; smaller ones are 0


def mujoco(model: Any, data: Any) -> EngineStep:
    """The step that `mujoco.mj_step(model, data)` takes from here. To be called just before it; it changes nothing.

    model: a mujoco.MjModel. data: a mujoco.MjData with controls and applied forces set. The problem includes contacts between
    geoms with every cone and condim, limits and dry friction of joints and tendons, and equality constraints as joints. The
    step of a copy of data calls the callbacks once more.

    Returns an EngineStep. The bias is the gap divided by the step, negative if bodies penetrate. The notes state the shares of
    torsional and rolling friction, of the softness of contacts and equalities, and of everything that no constraint explains,
    such as unsymmetric implicit terms of the integrator.
    Errors: InputError naming model without joints; data of another model, or that has diverged; integrator other than Euler,
    implicit and implicitfast; contact for moving surfaces and flexes without friction; step if the engine's next velocity
    differs from the problem's.
    """
    import mujoco as mj

    require_usable(mj, model, data)
    require(model.opt.integrator in known(mj), "integrator", "must be Euler, implicit or implicitfast")
    h = float(model.opt.timestep)
    after = mj.MjData(model)
    mj.mj_copyData(after, model, data)
    mj.mj_step(model, after)
    bad = mj.mjtWarning.mjWARN_BADQACC
    require(after.warning[bad].number == data.warning[bad].number, "data", "MuJoCo resets it: the simulation has diverged")
    mass = mass_of(mj, model, after)
    require_finite(mass, after.qfrc_smooth)
    free = data.qvel + h * np.linalg.solve(mass, after.qfrc_smooth)
    free[((data.tree_asleep >= 0) & (after.tree_asleep >= 0))[model.dof_treeid]] = 0.0
    J, force, kinds = jacobian(mj, model, after), after.efc_force.copy(), kinds_of(mj, after)
    contacts, others = rows_of(mj, model, after, J, kinds)
    symmetric = (mass + mass.T) / 2
    touching = ~(kinds.limit | kinds.dry | kinds.equal)
    soft = {"softness of contacts": touching, "softness of equalities": kinds.equal}
    given = after.efc_R * force  # R f
    shares = {name: share_of_softness(symmetric, J[on].T @ force[on], force[on] @ given[on]) for name, on in soft.items()}
    return captured(Step(symmetric, free, after.qvel.copy(), h, contacts, J[kinds.equal], others, shares))


class Kinds(NamedTuple):
    """Masks: the entries of data.contact that have rows; the rows (nefc,) of limits, of dry friction and of equalities."""

    touching: Mask
    limit: Mask
    dry: Mask
    equal: Mask


def kinds_of(mj: Any, data: Any) -> Kinds:
    """The kinds of MuJoCo's constraints; limits and dry friction are of joints and tendons."""
    kind, at = data.efc_type, mj.mjtConstraint  # int() because numpy compares enum members one by one
    limit = (kind == int(at.mjCNSTR_LIMIT_JOINT)) | (kind == int(at.mjCNSTR_LIMIT_TENDON))
    dry = (kind == int(at.mjCNSTR_FRICTION_DOF)) | (kind == int(at.mjCNSTR_FRICTION_TENDON))
    return Kinds(data.contact.efc_address >= 0, limit, dry, kind == int(at.mjCNSTR_EQUALITY))


def require_usable(mj: Any, model: Any, data: Any) -> None:
    """Check that data belongs to this model, or MuJoCo would access memory beyond its arrays, and that it has not diverged."""
    require(isinstance(model, mj.MjModel), "model", f"must be a mujoco.MjModel, got {type(model)}")
    own = isinstance(data, mj.MjData) and data.signature == model.signature
    require(own, "data", "must be a mujoco.MjData that was made for this model")
    within = np.abs(np.concatenate([data.qpos, data.qvel])) <= mj.mjMAXVAL
    require(bool(within.all()), "data", "MuJoCo would reset it: the simulation has diverged")


def known(mj: Any) -> tuple[Any, ...]:
    """The integrators whose steps have a single set of impulses."""
    return mj.mjtIntegrator.mjINT_EULER, mj.mjtIntegrator.mjINT_IMPLICIT, mj.mjtIntegrator.mjINT_IMPLICITFAST


def mass_of(mj: Any, model: Any, data: Any) -> Array:
    """A (nv, nv), the mass matrix with which impulses act in the integrator. data: after the step."""
    require(model.nv > 0, "model", "has no joints: nothing can move")
    mass, h = np.zeros((model.nv, model.nv)), model.opt.timestep
    mj.mj_fullM(model, data, mass)
    if model.opt.integrator not in known(mj)[1:]:
        off = mj.mjtDisableBit.mjDSBL_EULERDAMP | mj.mjtDisableBit.mjDSBL_DAMPER
        if not model.opt.disableflags & int(off):
            mass[np.diag_indices(model.nv)] += h * model.dof_damping
        return mass
    at = np.repeat(np.arange(model.nv), model.D_rownnz), model.D_colind
    mass[at] -= h * data.qDeriv
    if model.opt.integrator == mj.mjtIntegrator.mjINT_IMPLICITFAST:  # it uses only the lower triangle
        return np.tril(mass) + np.tril(mass, -1).T
    require_finite(mass)
    reason = "implicit's mass is not positive definite at the velocities that light bodies have; use implicitfast"
    require(bool((np.linalg.eigvalsh(mass + mass.T) > 0).all()), "integrator", reason)
    return mass


def jacobian(mj: Any, model: Any, data: Any) -> Array:
    """The rows of all constraints (nefc, nv)."""
    if not mj.mj_isSparse(model):
        return np.array(data.efc_J).reshape(data.nefc, model.nv)
    ends = np.append(data.efc_J_rowadr, len(data.efc_J)) if data.nefc else np.zeros(1, int)
    return sparse.csr_array((data.efc_J, data.efc_J_colind, ends), shape=(data.nefc, model.nv)).toarray()


def rows_of(mj: Any, model: Any, data: Any, J: Array, kinds: Kinds) -> tuple[Contacts, dict[str, Array]]:
    """The contacts, limits and dry friction in MuJoCo's constraints J (nefc, nv), and the generalised impulses of torsional and
    rolling friction."""
    h = float(model.opt.timestep)
    contacts, others = _contacts(mj, model, data, J, kinds.touching)
    limit, dry = kinds.limit, kinds.dry
    gap, used = data.efc_pos - data.efc_margin, h * data.efc_force
    rows = contacts.and_limits(J[limit], used[limit], gap[limit])
    return rows.and_dry_friction(J[dry], used[dry], h * data.efc_frictionloss[dry], h), others


def _contacts(mj: Any, model: Any, data: Any, J: Array, mask: Mask) -> tuple[Contacts, dict[str, Array]]:
    """The contacts, and the generalised impulses of their torsional and rolling friction."""
    rows, impulses, friction = [np.zeros((0, model.nv))], [np.zeros((0, 3))], []
    others = {"torsional friction": np.zeros(model.nv), "rolling friction": np.zeros(model.nv)}
    at, touching, h = data.contact, np.flatnonzero(mask), float(model.opt.timestep)
    moves = getattr(at, "surfacevel", np.zeros((len(at.dim), 1)))  # unknown to MuJoCo before 4.0
    for number, first, dim in zip(touching.tolist(), at.efc_address[touching], at.dim[touching], strict=True):
        where = f"contact {number}"
        require(not moves[number].any(), where, "its surfaces move, which a problem cannot express")
        if dim == 1:
            rows_of_contact = np.vstack([J[first], _tangents(mj, model, data, at[number], where)])
            f, mu = np.array([data.efc_force[first], 0.0, 0.0]), 0.0
        else:
            mu = at.friction[number, :2].max()
            rows_of_contact, f = _decoded(mj, data, J, first, at.friction[number, : dim - 1])
            others["torsional friction"] += h * rows_of_contact[TORSION:ROLLING].T @ f[TORSION:ROLLING]
            others["rolling friction"] += h * rows_of_contact[ROLLING:].T @ f[ROLLING:]
            share = at.friction[number, :2] / mu
            rows_of_contact[1:3] *= share[:, None]
            f[1:3] /= share
        rows.append(rows_of_contact[:3])
        impulses.append(h * f[None, :3])
        friction.append(mu)
    gap = (at.dist - at.includemargin)[touching]
    sizes = (np.linalg.norm(data.geom_xpos[at.geom], axis=2) + model.geom_rbound[at.geom]).sum(axis=1)[touching]
    gap[np.abs(gap) <= GAP_ROUNDING * sizes] = 0.0  # a body that moves only along a plane could not remove such an overlap
    return Contacts(np.vstack(rows), np.vstack(impulses), np.array(friction), gap, np.zeros(len(gap))), others


def _decoded(mj: Any, data: Any, J: Array, first: int, mu: Array) -> tuple[Array, Array]:
    """The rows (dim, nv) and forces (dim,) of a contact in its frame. mu: its coefficients of friction (dim - 1,)."""
    dim = len(mu) + 1
    if data.efc_type[first] == int(mj.mjtConstraint.mjCNSTR_CONTACT_ELLIPTIC):
        return J[first : first + dim].copy(), data.efc_force[first : first + dim].copy()
    up, down = (slice(first + k, first + 2 * (dim - 1), 2) for k in (0, 1))
    a, b = data.efc_force[up], data.efc_force[down]
    normal = (J[first] + J[first + 1]) / 2
    return np.vstack([normal, (J[up] - J[down]) / (2 * mu[:, None])]), np.concatenate([[a.sum() + b.sum()], mu * (a - b)])


def _tangents(mj: Any, model: Any, data: Any, contact: Any, where: str) -> Array:
    """The tangents' rows (2, nv) of a contact without friction, which MuJoCo does not compute."""
    require(min(contact.geom) >= 0, where, "of a flex, without friction: its tangents are not known")
    jacobians = np.zeros((2, 3, model.nv))
    for jacobian, geom in zip(jacobians, contact.geom, strict=True):
        mj.mj_jac(model, data, jacobian, None, contact.pos, model.geom_bodyid[geom])
    return contact.frame.reshape(3, 3)[1:] @ (jacobians[1] - jacobians[0])
