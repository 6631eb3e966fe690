"""Steps captured from Drake: the engine's impulses, put into the problem, give the engine's own next velocity."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench import capture
from frictionbench.problems.analysis.labels import joint_rows
from frictionbench.problems.capture.parts import UNEXPLAINED

drake = pytest.importorskip("pydrake.all", reason="Drake is not installed: pip install drake")

SIDE, STEP = 0.2, 0.002


def pile(sampled: bool, approximation: str, upper: float = 100.0):
    """Three boxes by their corners on a slope and on each other, and a damped hinge that is driven."""
    builder = drake.DiagramBuilder()
    plant, _ = drake.AddMultibodyPlantSceneGraph(builder, STEP)
    ground = drake.CoulombFriction(0.9, 0.6)
    half = drake.HalfSpace()
    plant.RegisterCollisionGeometry(plant.world_body(), drake.RigidTransform(), half, "ground", ground)
    inertia = drake.SpatialInertia.SolidBoxWithMass(2.0, SIDE, SIDE, SIDE)
    for k in range(3):
        model = plant.AddModelInstance(f"model {k}")
        body = plant.AddRigidBody(f"box {k}", model, inertia)
        for corner in np.ndindex(2, 2, 2):
            at = drake.RigidTransform(SIDE * (np.array(corner) - 0.5))
            plant.RegisterCollisionGeometry(body, at, drake.Sphere(1e-7), f"corner {corner}", drake.CoulombFriction(0.4, 0.3))
        box = drake.Box(SIDE, SIDE, SIDE)
        plant.RegisterCollisionGeometry(body, drake.RigidTransform(), box, "box", drake.CoulombFriction(0.4, 0.3))
    arm = plant.AddRigidBody("arm", plant.AddModelInstance("arm"), inertia)
    hinge = drake.RevoluteJoint("hinge", plant.world_frame(), arm.body_frame(), [0, 1, 0], -100.0, upper, 0.7)
    plant.AddJointActuator("motor", plant.AddJoint(hinge))
    plant.set_contact_model(drake.ContactModel.kPoint)
    plant.set_discrete_contact_approximation(getattr(drake.DiscreteContactApproximation, approximation))
    plant.SetUseSampledOutputPorts(sampled)
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    plant.get_actuation_input_port().FixValue(own, [5.0])
    for k in range(3):
        pose = drake.RigidTransform(drake.RollPitchYaw(0.02 * k, 0.01, 0.1 * k), [0.02 * k, 0, SIDE * (0.5 + 1.02 * k)])
        plant.SetFreeBodyPose(own, plant.GetBodyByName(f"box {k}"), pose)
        velocity = drake.SpatialVelocity([0.2, 0.1 * k, 0.3], [0.5, 0.2 * k, 0.0])
        plant.SetFreeBodySpatialVelocity(own, plant.GetBodyByName(f"box {k}"), velocity)
    plant.GetJointByName("hinge").set_angle(own, 0.05)
    return plant, drake.Simulator(diagram, context)


@pytest.mark.parametrize(("sampled", "approximation"), [(True, "kLagged"), (False, "kSap"), (True, "kSimilar")])
def test_impulses_reproduce_the_next_velocity(sampled, approximation) -> None:
    plant, simulator = pile(sampled, approximation)
    noted: set[str] = set()
    most = 0
    for k in range(8):
        simulator.AdvanceTo((10 * k + 20) * STEP)
        step = capture.drake(plant, simulator.get_context())
        simulator.AdvanceTo((10 * k + 21) * STEP)
        after = plant.GetVelocities(plant.GetMyContextFromRoot(simulator.get_context()))
        assert np.abs(step.problem.velocity(step.impulse) - after).max() < 1e-9
        assert set(np.round(step.problem.friction, 12)) <= {0.4, 0.3}
        most, noted = max(most, step.problem.contacts), noted | step.notes.keys()
        assert step.notes.get(UNEXPLAINED, 0.0) < 1e-4  # Drake's solver stops at a tolerance
    assert most >= 6
    assert noted - {UNEXPLAINED} == {"softness of contacts"}


def test_free_velocity_is_the_engines() -> None:
    """Without contacts nothing remains unexplained: gravity, damping, gyroscopic terms and the motor are known."""
    plant, simulator = pile(True, "kLagged")
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for k in range(3):
        at = drake.RigidTransform(drake.RollPitchYaw(0.3, 0.2, 0.1), [0, 0, 3.0 + k])
        plant.SetFreeBodyPose(context, plant.GetBodyByName(f"box {k}"), at)
        plant.SetFreeBodySpatialVelocity(
            context, plant.GetBodyByName(f"box {k}"), drake.SpatialVelocity([3.0, 1, 2], [0, 1, 0])
        )
    plant.GetJointByName("hinge").set_angular_rate(context, -1.0)
    step = capture.drake(plant, simulator.get_context())
    assert (step.problem.contacts, step.notes) == (0, {})
    simulator.AdvanceTo(STEP)
    after = plant.GetVelocities(plant.GetMyContextFromRoot(simulator.get_context()))
    assert np.abs(step.problem.free_velocity - after).max() < 1e-12


def test_contexts_of_the_plant_alone_are_refused() -> None:
    plant, simulator = pile(True, "kLagged")
    with pytest.raises(fb.InputError, match="context: expected that of the diagram"):
        capture.drake(plant, plant.GetMyContextFromRoot(simulator.get_context()))


def test_limits_are_rows() -> None:
    plant, simulator = pile(True, "kLagged", upper=0.051)
    simulator.AdvanceTo(10 * STEP)
    step = capture.drake(plant, simulator.get_context())
    limit, _ = joint_rows(step.problem)
    hinge = plant.GetJointByName("hinge").velocity_start()
    assert step.problem.normal.toarray()[limit].tolist() == [[-float(i == hinge) for i in range(plant.num_velocities())]]
    assert step.impulse[limit, 0] > 0.01  # of 5 N m for 2 ms
    assert step.notes.get(UNEXPLAINED, 0.0) < 1e-4
    simulator.AdvanceTo(11 * STEP)
    after = plant.GetVelocities(plant.GetMyContextFromRoot(simulator.get_context()))
    assert np.abs(step.problem.velocity(step.impulse) - after).max() < 1e-9


def test_contacts_by_surfaces_are_noted() -> None:
    builder = drake.DiagramBuilder()
    plant, _ = drake.AddMultibodyPlantSceneGraph(builder, STEP)
    body = plant.AddRigidBody("ball", drake.SpatialInertia.SolidSphereWithMass(1.0, SIDE))
    for owner, shape, name in ((plant.world_body(), drake.HalfSpace(), "ground"), (body, drake.Sphere(SIDE), "ball")):
        properties = drake.ProximityProperties()
        drake.AddContactMaterial(friction=drake.CoulombFriction(0.5, 0.5), properties=properties)
        if name == "ball":
            drake.AddCompliantHydroelasticProperties(0.1, 1e6, properties)
        else:
            drake.AddRigidHydroelasticProperties(properties)
        plant.RegisterCollisionGeometry(owner, drake.RigidTransform(), shape, name, properties)
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    plant.SetFreeBodyPose(own, body, drake.RigidTransform([0, 0, 0.98 * SIDE]))
    plant.SetFreeBodySpatialVelocity(own, body, drake.SpatialVelocity([0, 2.0, 0], [1.0, 0, 0]))
    step = capture.drake(plant, context)
    assert step.problem.contacts == 0
    assert step.notes["contacts by surfaces"] == pytest.approx(1.0, abs=1e-6)
