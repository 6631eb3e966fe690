"""Steps captured from engines are judged, where the engines are installed: they creep and open as their models say."""

import pytest

from frictionbench import capture
from frictionbench.harness.judge import judge_file

BLOCK = """
<mujoco>
  <option cone="{cone}"/>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
    <body pos="1 0 .1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
    <body pos="1 0 .3"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
  </worldbody>
</mujoco>"""


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_steps_of_mujoco(tmp_path, cone) -> None:
    mj = pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco")
    model = mj.MjModel.from_xml_string(BLOCK.format(cone=cone))
    data = mj.MjData(model)
    for _ in range(300):
        mj.mj_step(model, data)
    model.opt.gravity[0] = 4.0  # less than friction holds
    for _ in range(20):
        mj.mj_step(model, data)
    path = capture.mujoco(model, data).save(tmp_path)
    found = judge_file(tmp_path, path)
    assert found.contacts == 12
    assert found.law == "dissipation"
    assert 1e-5 < found.creep < 1e-1  # m/s, inside the cone
    assert 1e-6 < found.penetration < 1e-2
    assert found.residual > 100 * found.floor


def test_steps_of_drake(tmp_path) -> None:
    drake = pytest.importorskip("pydrake.all", reason="Drake is not installed: pip install drake")
    builder = drake.DiagramBuilder()
    plant, _ = drake.AddMultibodyPlantSceneGraph(builder, 0.002)
    friction = drake.CoulombFriction(0.5, 0.5)
    plant.RegisterCollisionGeometry(plant.world_body(), drake.RigidTransform(), drake.HalfSpace(), "ground", friction)
    for k in range(2):
        ball = plant.AddRigidBody(
            f"ball {k}", plant.AddModelInstance(f"{k}"), drake.SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        )
        plant.RegisterCollisionGeometry(ball, drake.RigidTransform(), drake.Sphere(0.1), "ball", friction)
    plant.Finalize()
    simulator = drake.Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for k in range(2):
        body = plant.GetBodyByName(f"ball {k}")
        plant.SetFreeBodyPose(context, body, drake.RigidTransform([0.5 * k, 0, 0.0999]))
        plant.SetFreeBodySpatialVelocity(context, body, drake.SpatialVelocity([0, 0, 0], [1.0 * k, 0, 0]))
    simulator.AdvanceTo(0.02)
    path = capture.drake(plant, simulator.get_context()).save(tmp_path)
    found = judge_file(tmp_path, path)
    assert found.contacts == 2
    assert found.penetration > 0
    assert found.residual > 100 * found.floor
