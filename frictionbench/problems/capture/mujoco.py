"""A step of MuJoCo as a friction problem.

The step is taken on a copy of the data, by mj_step itself, and so are the velocity without constraints and, one unit impulse a
velocity, the matrix M^-1 by which the integrator turns impulses into velocities: M with implicit damping, for those that have
it. Each contact has rows J of MuJoCo's constraints in its frame, normal first:

    elliptic    J_n, J_1, J_2, ... themselves, forces f_n, f_1, f_2, ...
    pyramidal   edges J_n +- mu_k J_k, forces a_k+-:     f_n = sum a,  f_k = mu_k (a_k+ - a_k-)

Friction of two coefficients is that of mu_1 with the second tangent's row times mu_2/mu_1 and its impulse times mu_1/mu_2.
Sources: MuJoCo's documentation, "Computation", sections on the constraint model; mju_decodePyramid.
"""

import copy
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems.capture.parts import Contacts, Step, captured, share_of_softness
from frictionbench.problems.check import Array, InputError, require
from frictionbench.problems.recorded.own import EngineStep

TORSION, ROLLING = 3, 4  # rows of a contact from which on it resists torsion, and rolling


def mujoco(model: Any, data: Any) -> EngineStep:
    """The step that `mujoco.mj_step(model, data)` takes from here; called just before it, and changes nothing.

    model: a mujoco.MjModel. data: a mujoco.MjData with controls and applied forces set. Every cone and condim of contacts
    between geoms is taken, and equality constraints as joints. The step of a copy of data calls the callbacks once more.

    Returns an EngineStep: the bias is the gap over the step, negative where bodies penetrate; notes hold the shares of limits,
    of dry friction in joints, of torsional and rolling friction, of what softness takes of contacts and equalities, and of what
    no constraint explains, as adhesion, or implicit terms of the integrator that are not symmetric.
    Errors: InputError naming integrator for RK4, whose step has four sets of impulses; contact for moving surfaces and flexes
    without friction; step where the engine's next velocity is not that of the problem.
    """
    import mujoco as mj

    if model.opt.integrator == mj.mjtIntegrator.mjINT_RK4:
        raise InputError("integrator: a step of RK4 has the impulses of four stages; use another to capture steps")
    h = float(model.opt.timestep)
    after = mj.MjData(model)
    mj.mj_copyData(after, model, data)
    mj.mj_step(model, after)
    mass, free = _probed(mj, model, data)
    J, force, kind = _jacobian(mj, model, after), after.efc_force.copy(), after.efc_type.copy()
    at = mj.mjtConstraint
    equal = kind == at.mjCNSTR_EQUALITY
    touching = kind >= int(at.mjCNSTR_CONTACT_FRICTIONLESS)
    contacts, others = _contacts(mj, model, after, J, h)
    groups = {
        "dry friction of joints": (kind == at.mjCNSTR_FRICTION_DOF) | (kind == at.mjCNSTR_FRICTION_TENDON),
        "limits": (kind == at.mjCNSTR_LIMIT_JOINT) | (kind == at.mjCNSTR_LIMIT_TENDON),
    }
    others |= {name: h * J[rows].T @ force[rows] for name, rows in groups.items()}
    soft = {"softness of contacts": touching, "softness of equalities": equal}
    shares = {name: share_of_softness(mass, J[rows], force[rows], after.efc_R[rows]) for name, rows in soft.items()}
    return captured(Step(mass, free, after.qvel.copy(), h, contacts, J[equal], others, shares))


def _probed(mj: Any, model: Any, data: Any) -> tuple[Array, Array]:
    """The mass that impulses meet, and the next velocity without constraints, as the engine's integrator has them."""
    free, trial = copy.copy(model), mj.MjData(model)
    free.opt.disableflags |= int(mj.mjtDisableBit.mjDSBL_CONSTRAINT)
    full = np.zeros((model.nv, model.nv))
    mj.mj_fullM(model, data, full)
    unit = np.maximum(np.diag(full), 1e-12) / model.opt.timestep  # changes a velocity by about one
    moved = np.zeros((model.nv + 1, model.nv))
    for i, velocity in enumerate(moved):
        mj.mj_copyData(trial, model, data)
        if i < model.nv:
            trial.qfrc_applied[i] += unit[i]
        mj.mj_step(free, trial)
        velocity[:] = trial.qvel
    return np.linalg.inv((moved[:-1] - moved[-1]).T / (unit * model.opt.timestep)), moved[-1]


def _jacobian(mj: Any, model: Any, data: Any) -> Array:
    """The rows of all constraints (nefc, nv)."""
    if not mj.mj_isSparse(model):
        return np.array(data.efc_J).reshape(data.nefc, model.nv)
    ends = np.append(data.efc_J_rowadr, len(data.efc_J)) if data.nefc else np.zeros(1, int)
    return sparse.csr_array((data.efc_J, data.efc_J_colind, ends), shape=(data.nefc, model.nv)).toarray()


def _contacts(mj: Any, model: Any, data: Any, J: Array, h: float) -> tuple[Contacts, dict[str, Array]]:
    """The contacts, and the generalised impulses of their torsion and rolling."""
    rows, impulses, friction, gaps = [np.zeros((0, model.nv))], [np.zeros((0, 3))], [], []
    others = {"torsional friction": np.zeros(model.nv), "rolling friction": np.zeros(model.nv)}
    for number, contact in enumerate(data.contact):
        first, dim = int(contact.efc_address), int(contact.dim)
        if first < 0:
            continue
        where = f"contact {number}"
        require(not np.any(getattr(contact, "surfacevel", 0.0)), where, "its surfaces move, which a problem cannot express")
        if dim == 1:
            own = np.vstack([J[first], _tangents(mj, model, data, contact, where)])
            f, mu = np.array([data.efc_force[first], 0.0, 0.0]), 0.0
        else:
            own, f = _decoded(mj, model, data, J, first, contact)
            mu, ratio = float(contact.friction[0]), float(contact.friction[1] / contact.friction[0])
            others["torsional friction"] += h * own[TORSION:ROLLING].T @ f[TORSION:ROLLING]
            others["rolling friction"] += h * own[ROLLING:].T @ f[ROLLING:]
            own[2] *= ratio
            f[2] /= ratio
        rows.append(own[:3])
        impulses.append(h * f[None, :3])
        friction.append(mu)
        gaps.append(float(contact.dist - contact.includemargin))
    return Contacts(np.vstack(rows), np.vstack(impulses), np.array(friction), np.array(gaps)), others


def _decoded(mj: Any, model: Any, data: Any, J: Array, first: int, contact: Any) -> tuple[Array, Array]:
    """The rows (dim, nv) and forces (dim,) of a contact with friction in its frame."""
    dim = int(contact.dim)
    if data.efc_type[first] == mj.mjtConstraint.mjCNSTR_CONTACT_ELLIPTIC:
        return J[first : first + dim].copy(), data.efc_force[first : first + dim].copy()
    mu = contact.friction[: dim - 1]
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
