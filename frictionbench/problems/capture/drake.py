"""A step of Drake's discrete MultibodyPlant as a friction problem.

The plant's own update takes the step on clones of the context, and its contact results are the forces of that step. Let C be
the point of a contact, n its normal from B to A, and f the force on B. The contact's rows give v_B - v_A at C in the frame
(-n, t_1, t_2), and its impulse is h f in this frame. Without constraints the plant's step is

    (M + h D) (v0 - v) = h tau(q, v),

where D is the damping of the joints and tau the forces of gravity, springs, damping and actuators minus the Coriolis terms.
Source: pydrake's documentation of MultibodyPlant, sections on discrete time and on contact.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from frictionbench.problems.capture.parts import Contacts, Step, captured, share_of_softness
from frictionbench.problems.check import Array, InputError, require
from frictionbench.problems.recorded.native import EngineStep
from frictionbench.problems.spatial.rotation import frames


def drake(plant: Any, context: Any) -> EngineStep:
    """The step that the plant takes from this context. To be called just before the step; it changes nothing.

    plant: a finalized MultibodyPlant in discrete time, in a diagram with its SceneGraph. context: the diagram's context, from
    `simulator.get_context()`. All point contacts are included, and those limits of joints with one coordinate that the joint
    violates or would violate in this step without them.

    Returns an EngineStep. The bias is the gap divided by the step, negative if bodies penetrate. The notes state the shares of
    hydroelastic contacts, of the softness of contacts, and of everything else, such as constraints between joints.
    Errors: InputError naming plant or context, or step if the engine's next velocity differs from the problem's.
    """
    h = float(plant.time_step())
    require(h > 0, "plant", "is in continuous time, which has no steps with impulses")
    now, after, results = _stepped(plant, context)
    nv = plant.num_velocities()
    mass = plant.CalcMassMatrix(now) + h * np.diag(_damping(plant, now))
    free = plant.GetVelocities(now) + h * np.linalg.solve(mass, _forces(plant, now, after))
    velocity = plant.GetVelocities(after)
    contacts = _contacts(plant, now, results, h)
    surfaces = np.zeros(nv)
    for i in range(results.num_hydroelastic_contacts()):
        surfaces += h * _by_surface(plant, now, results.hydroelastic_contact_info(i))
    approach = (contacts.rows @ velocity).reshape(-1, 3)[:, 0] + contacts.gap / h
    soft = float(contacts.impulse[:, 0] @ np.maximum(-approach, 0.0))
    pushed = contacts.rows.T @ contacts.impulse.ravel()
    shares = {"softness of contacts": share_of_softness(mass, pushed, soft)}
    signs, gaps = _limits(plant, now, free, h)
    left = mass @ (velocity - free) - pushed - surfaces
    contacts = contacts.and_limits(signs, np.maximum(signs @ left, 0.0), gaps)
    return captured(Step(mass, free, velocity, h, contacts, np.zeros((0, nv)), {"contacts by surfaces": surfaces}, shares))


def _limits(plant: Any, now: Any, free: Array, h: float) -> tuple[Array, Array]:
    """Rows (n, nv), with one entry of 1 or -1, and gaps (n,) of the limits that joints reach in h at their free velocities."""
    q, rows, gaps = plant.GetPositions(now), [np.zeros((0, len(free)))], []
    for joint in _joints(plant):
        if joint.num_positions() != 1 or joint.num_velocities() != 1:
            continue
        at, lower, upper = q[joint.position_start()], joint.position_lower_limits()[0], joint.position_upper_limits()[0]
        for sign, gap in ((1.0, at - lower), (-1.0, upper - at)):
            row = np.zeros(len(free))
            row[joint.velocity_start()] = sign
            if min(gap, gap + h * row @ free) < 0:
                rows.append(row[None])
                gaps.append(gap)
    return np.vstack(rows), np.array(gaps)


def _stepped(plant: Any, context: Any) -> tuple[Any, Any, Any]:
    """Clones of the plant's context before and after the step, and the contact results of the step."""
    try:
        now, after = (plant.GetMyMutableContextFromRoot(context.Clone()) for _ in range(2))
    except RuntimeError as error:
        raise InputError(f"context: expected that of the diagram, simulator.get_context() ({str(error)[:100]})") from None
    port = plant.get_contact_results_output_port()
    if plant.has_sampled_output_ports():
        plant.CalcForcedUnrestrictedUpdate(now, after.get_mutable_state())
        return now, after, port.Eval(after)
    plant.CalcForcedDiscreteVariableUpdate(now, after.get_mutable_discrete_state())
    return now, after, port.Eval(now)


def _joints(plant: Any) -> Iterator[Any]:
    return map(plant.get_joint, plant.GetJointIndices())


def _damping(plant: Any, now: Any) -> Array:
    """The damping of the joints (nv,), which the plant integrates implicitly."""
    result = np.zeros(plant.num_velocities())
    for joint in _joints(plant):
        damping = joint.GetDampingVector(now)
        result[joint.velocity_start() : joint.velocity_start() + len(damping)] = damping
    return result


def _forces(plant: Any, now: Any, after: Any) -> Array:
    """tau (nv,): all forces except those of constraints and contacts."""
    from pydrake.multibody.tree import MultibodyForces

    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(now, forces)
    applied = plant.get_applied_generalized_force_input_port()
    if applied.HasValue(now):
        forces.mutable_generalized_forces()[:] += applied.Eval(now)
    if plant.num_actuated_dofs():
        sampled = after if plant.has_sampled_output_ports() else now
        actuation = plant.get_net_actuation_output_port().Eval(sampled)
        forces.mutable_generalized_forces()[:] += plant.MakeActuationMatrix() @ actuation
    return -plant.CalcInverseDynamics(now, np.zeros(plant.num_velocities()), forces)


def _contacts(plant: Any, now: Any, results: Any, h: float) -> Contacts:
    nv, rows, impulses, friction, gaps = plant.num_velocities(), [], [], [], []
    inspector = plant.EvalSceneGraphInspector(now)
    for info in (results.point_pair_contact_info(i) for i in range(results.num_point_pair_contacts())):
        pair = info.point_pair()
        frame = frames(-pair.nhat_BA_W[None])[0]
        jacobian = _translation(plant, now, info.bodyB_index(), info.contact_point()) - _translation(
            plant, now, info.bodyA_index(), info.contact_point()
        )
        rows.append(frame @ jacobian)
        impulses.append(h * frame @ info.contact_force())
        friction.append(_friction(inspector, pair.id_A, pair.id_B))
        gaps.append(-pair.depth)
    law = np.array(friction, dtype=float), np.array(gaps), np.zeros(len(gaps))
    return Contacts(np.array(rows).reshape(-1, nv), np.array(impulses).reshape(-1, 3), *law)


def _translation(plant: Any, now: Any, body: Any, point: Array) -> Array:
    """The Jacobian (3, nv) of the velocity of a body at a point in the world."""
    from pydrake.multibody.tree import JacobianWrtVariable

    frame, world = plant.get_body(body).body_frame(), plant.world_frame()
    at = plant.CalcPointsPositions(now, world, np.asarray(point).reshape(3, 1), frame)
    return plant.CalcJacobianTranslationalVelocity(now, JacobianWrtVariable.kV, frame, at, world, world)


def _friction(inspector: Any, *ids: Any) -> float:
    """The plant's combination 2 mu_A mu_B / (mu_A + mu_B) of dynamic coefficients; the static ones are not used."""
    a, b = (inspector.GetProximityProperties(one).GetProperty("material", "coulomb_friction").dynamic_friction() for one in ids)
    return 2 * a * b / (a + b) if a + b > 0 else 0.0


def _by_surface(plant: Any, now: Any, info: Any) -> Array:
    """The generalised force (nv,) of a hydroelastic contact, from the force and the moment at its centroid."""
    from pydrake.multibody.tree import JacobianWrtVariable

    inspector, surface = plant.EvalSceneGraphInspector(now), info.contact_surface()
    centroid, force, result = surface.centroid(), info.F_Ac_W(), np.zeros(plant.num_velocities())
    for geometry, sign in ((surface.id_M(), 1.0), (surface.id_N(), -1.0)):
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        frame, world = body.body_frame(), plant.world_frame()
        spin = plant.CalcJacobianAngularVelocity(now, JacobianWrtVariable.kV, frame, world, world)
        result += sign * (
            _translation(plant, now, body.index(), centroid).T @ force.translational() + spin.T @ force.rotational()
        )
    return result
