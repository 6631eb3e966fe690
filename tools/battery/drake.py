"""Drake: hydroelastic contact surfaces, with the moduli and the margin named in its documentation."""

from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from tools.battery.world import Array, Setting, Unsupported, gravity


class Drake:
    """A setting as a MultibodyPlant. modulus: Pa; margin: m; stiction: its tolerance, m/s; integrator: of a continuous plant.

    By default bodies are compliant, which has to be requested, with the default modulus, on rigid half spaces; kLagged.
    """

    def __init__(
        self,
        setting: Setting,
        step: float,
        modulus: float = 1e7,
        approximation: str = "kLagged",
        margin: float | None = None,
        stiction: float = 1e-4,
        integrator: str = "",
    ) -> None:
        if setting.restitution:
            raise Unsupported("its dissipation has no coefficient of restitution, and implicit steps damp it besides")
        d: Any = import_module("pydrake.all")
        builder = d.DiagramBuilder()
        self._plant, scene = d.AddMultibodyPlantSceneGraph(builder, 0.0 if integrator else step)
        config = d.SceneGraphConfig()
        config.default_proximity_properties.compliance_type = "compliant"
        config.default_proximity_properties.hydroelastic_modulus = modulus
        config.default_proximity_properties.margin = margin
        scene.set_config(config)
        if not integrator:
            self._plant.set_discrete_contact_approximation(getattr(d.DiscreteContactApproximation, approximation))
        self._plant.set_stiction_tolerance(stiction)
        self._plant.mutable_gravity_field().set_gravity_vector(setting.gravity)
        friction, ground = d.CoulombFriction(setting.friction, setting.friction), self._plant.world_body()
        for k, turn in enumerate(setting.floors):
            pose = d.RigidTransform(d.RotationMatrix.MakeXRotation(turn))
            properties = d.ProximityProperties()
            d.AddRigidHydroelasticProperties(properties)
            d.AddContactMaterial(friction=friction, properties=properties)
            self._plant.RegisterCollisionGeometry(ground, pose, d.HalfSpace(), f"floor {k}", properties)
        self._bodies, self._masses, self._gravity = [], [body.mass for body in setting.bodies], setting.gravity
        for k, body in enumerate(setting.bodies):
            ball = len(body.size) == 1
            shape = d.Sphere(*body.size) if ball else d.Box(*(2 * np.array(body.size)))
            inertia = d.SpatialInertia(body.mass, np.zeros(3), d.UnitInertia(*(setting.volume_inertia[k] / body.mass)))
            one = self._plant.AddRigidBody(f"body {k}", self._plant.AddModelInstance(f"model {k}"), inertia)
            self._plant.RegisterCollisionGeometry(one, d.RigidTransform(), shape, "shape", friction)
            self._bodies.append(one)
        self._plant.Finalize()
        self._simulator = d.Simulator(builder.Build())
        if integrator:
            d.ApplySimulatorConfig(d.SimulatorConfig(integration_scheme=integrator, max_step_size=step), self._simulator)
        context = self._context = self._plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())
        for one, body in zip(self._bodies, setting.bodies, strict=True):
            pose = d.RigidTransform(d.RotationMatrix.MakeXRotation(body.turn), body.position)
            self._plant.SetFreeBodyPose(context, one, pose)
            self._plant.SetFreeBodySpatialVelocity(context, one, d.SpatialVelocity(body.spin, body.velocity))

    def run(self, seconds: float) -> None:
        self._simulator.AdvanceTo(self._simulator.get_context().get_time() + seconds)

    def tilt(self, slope: float) -> None:
        """Apply forces at the centres of mass, since a plant's gravity is fixed."""
        force = np.zeros((len(self._bodies), 6))
        for one, mass in zip(self._bodies, self._masses, strict=True):
            start = one.floating_velocities_start_in_v() // 6
            force[start, 3:] = mass * (gravity(slope) - self._gravity)
        self._plant.get_applied_generalized_force_input_port().FixValue(self._context, force.ravel())

    def position(self, body: int) -> Array:
        return np.array(self._plant.EvalBodyPoseInWorld(self._context, self._bodies[body]).translation())

    def velocity(self, body: int) -> Array:
        velocity = self._plant.EvalBodySpatialVelocityInWorld(self._context, self._bodies[body])
        return np.array(velocity.translational())


softer = partial(Drake, modulus=1e6)  # with it these light boxes are no longer nearly rigid at these steps
sap = partial(Drake, approximation="kSap")  # convex, without lagged quantities
cenic = partial(Drake, integrator="cenic")  # with error control and steps of at most the given length
margin = partial(Drake, margin=1e-4)  # named in the documentation: faces within it keep their contact
# A larger modulus than the documentation advises, with kSimilar and a smaller stiction tolerance.
stiff = partial(Drake, modulus=1e9, approximation="kSimilar", stiction=1e-6)
