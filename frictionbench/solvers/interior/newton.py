"""Newton's method on contacts with Coulomb friction, reduced to the velocities.

With the unknowns x and partners s of solvers.interior.point, r = H x a contact's impulse and K for the parts in which its own
unknowns act on its s, a step of an interior point method is the linear system

    x ∘ ds + dx ∘ s = target,      ds = H'du + K dx + defect,      M dv = J'H dx + F'dlam,      du = J dv,
    F dv = -joint defect.

Given du, each contact is four equations for itself, B dx = g - H'du, solved by formula (solvers.interior.planar_newton and
solvers.interior.spatial_newton). What is left is A dv = b in the velocities with

    A = M + sum_i J_i' C_i J_i + F'F/delta,      C_i = H B^-1 H',

a sum of small matrices, factorised by solvers.sparse_lu.multifrontal. A is singular where the impulses are not unique, so
delta, a tiny multiple of the contacts' own size, is added to the diagonals of B: Newton's matrix is inexact by it, the defects
are not, and the error is driven out by the next step. Where the impulses are far from unique, a tiny delta lets rounding of the
velocities end all progress, so that the predictor-corrector enlarges it there. A joint is a row of C = 1/delta for the same
reason: redundant joints are allowed.
"""

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import part
from frictionbench.solvers.interior.elements import larger
from frictionbench.solvers.interior.planar_newton import (
    add_planar_right_side,
    add_planar_stiffness,
    planar_defects,
    planar_steps,
    push_planar_impulses,
)
from frictionbench.solvers.interior.point import Point
from frictionbench.solvers.interior.spatial_newton import (
    add_spatial_right_side,
    add_spatial_stiffness,
    push_spatial_impulses,
    spatial_defects,
    spatial_steps,
)
from frictionbench.solvers.interior.system import JOINT_SOFTNESS, Elements, Space, System, Work
from frictionbench.solvers.sparse_lu.multifrontal import factorise, solve_factorised

PIVOT = 1e-14  # the least pivot of A, a hundred units of rounding, as the mass matrix is scaled to a unit diagonal


@part
def _push_joints(joints: Elements, impulse: Array, momentum: Array) -> None:
    for j in range(len(impulse)):
        for a in range(joints.start[j], joints.start[j + 1]):
            momentum[joints.column[a]] += joints.push[a, 0] * impulse[j, 0]


@part
def _read_joints(joints: Elements, v: Array, velocity: Array) -> None:
    for j in range(len(velocity)):
        velocity[j, 0] = 0.0
        for a in range(joints.start[j], joints.start[j + 1]):
            velocity[j, 0] += joints.read[a, 0] * v[joints.column[a]]


@part
def evaluate_point(system: System, space: Space, point: Point, defect: Point, work: Work) -> float:
    """The residual of problems.residual at a point's impulses, infinity where it is not a number.

    defect: overwritten with H'u + K x - s and F v + b_F.
    """
    v = work.vector
    for i in range(len(v)):
        work.momentum[i] = 0.0
    if space is None:
        push_planar_impulses(system, point.x, work.impulse, work.momentum)
    else:
        push_spatial_impulses(system, point.x, work.impulse, work.momentum)
    _push_joints(system.joints, point.joint, work.momentum)
    for i in range(len(v)):
        v[i] = system.free_velocity[i]
        for k in range(system.indptr[i], system.indptr[i + 1]):
            v[i] += system.inverse[k] * work.momentum[system.indices[k]]
    _read_joints(system.joints, v, defect.joint)
    if space is None:
        worst = planar_defects(system, point, v, work.impulse, defect.x)
    else:
        worst = spatial_defects(system, point, v, work.impulse, defect.x)
    for j in range(len(defect.joint)):
        defect.joint[j, 0] += system.joint_bias[j]
        worst = larger(worst, abs(defect.joint[j, 0]))
    return worst


@part
def linearise(system: System, space: Space, point: Point, work: Work) -> None:
    """Newton's matrix at a point, factorised."""
    for k in range(len(work.storage)):
        work.storage[k] = 0.0
    for k in range(len(system.slot)):
        work.storage[system.slot[k]] += system.constant[k]
    if space is None:
        add_planar_stiffness(system, point, work)
    else:
        add_spatial_stiffness(system, point, work)
    factorise(system.fronts, work.storage, work.swap, PIVOT)


@part
def direction(system: System, space: Space, point: Point, target: Array, defect: Point, step: Point, work: Work) -> None:
    """The step with x ∘ ds + dx ∘ s = target that removes the defect, after linearise at the same point."""
    dv = work.vector
    for i in range(len(dv)):
        dv[i] = 0.0
    if space is None:
        add_planar_right_side(system, target, defect.x, work)
    else:
        add_spatial_right_side(system, point, target, defect.x, step, work)
    for j in range(len(defect.joint)):
        step.joint[j, 0] = -defect.joint[j, 0] / JOINT_SOFTNESS
    _push_joints(system.joints, step.joint, dv)
    solve_factorised(system.fronts, work.storage, work.swap, dv)
    if space is None:
        planar_steps(system, point, target, step, work)
    else:
        spatial_steps(system, point, target, defect.x, step, work)
    _read_joints(system.joints, dv, work.joint_velocity)
    for j in range(len(defect.joint)):
        step.joint[j, 0] = -(defect.joint[j, 0] + work.joint_velocity[j, 0]) / JOINT_SOFTNESS
