"""Steps captured from MuJoCo: the engine's impulses, put into the problem, give the engine's own next velocity."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench import capture
from frictionbench.problems.analysis.labels import labels
from frictionbench.problems.capture.parts import UNEXPLAINED

mj = pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco")

# A figure with joints that falls on a pile: damping, limits, dry friction, a closed loop, contacts of every condim.
MODEL = """
<mujoco>
  <option cone="{cone}" integrator="{integrator}"/>
  <default><geom density="500"/></default>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body pos="0 0 .1"><freejoint/><geom type="box" size=".2 .2 .1" condim="6" friction=".6 .02 .003"/></body>
    <body pos=".05 0 .31" euler="3 5 7"><freejoint/><geom type="sphere" size=".1" condim="4"/></body>
    <body pos=".6 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" condim="1" priority="1"/></body>
    <body pos="0 0 1">
      <freejoint/><geom type="capsule" fromto="0 -.1 0 0 .1 0" size=".07"/>
      <body pos="0 -.1 -.1">
        <joint axis="0 1 0" damping=".3" range="-20 5" limited="true"/><geom type="capsule" fromto="0 0 0 .1 0 -.3" size=".05"/>
        <body pos=".1 0 -.3">
          <joint axis="0 1 0" frictionloss=".2" stiffness="2"/><geom type="capsule" fromto="0 0 0 -.1 0 -.3" size=".04"/>
        </body>
      </body>
      <body pos="0 .1 -.1"><joint type="ball" damping=".1"/><geom type="capsule" fromto="0 0 0 0 0 -.4" size=".05"/></body>
    </body>
    <body name="left" pos="-1 0 .06"><freejoint/><geom type="box" size=".1 .05 .05"/></body>
    <body name="right" pos="-1 0 .4"><freejoint/><geom type="box" size=".1 .05 .05"/></body>
  </worldbody>
  <equality><connect body1="left" body2="right" anchor="0 0 .17"/></equality>
</mujoco>"""
BLOCK = """
<mujoco>
  <option cone="{cone}" timestep=".004"/>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="2"/></body>
  </worldbody>
  {extra}
</mujoco>"""
TORSION, ROLLING = "torsional friction", "rolling friction"


def fallen(xml: str, steps: int, speed: float = 0.3):
    model = mj.MjModel.from_xml_string(xml)
    data = mj.MjData(model)
    data.qvel[:] = speed * np.sin(np.arange(model.nv))
    mj.mj_step(model, data, steps)
    return model, data


@pytest.mark.parametrize(
    ("cone", "integrator"),
    [("pyramidal", "Euler"), ("elliptic", "implicitfast"), ("elliptic", "Euler"), ("pyramidal", "implicit")],
)
def test_impulses_reproduce_the_next_velocity(cone, integrator) -> None:
    model, data = fallen(MODEL.format(cone=cone, integrator=integrator), 150)
    noted: set[str] = set()
    limits = dry = 0
    for _ in range(6):
        state = data.qpos.copy(), data.qvel.copy(), data.time
        step = capture.mujoco(model, data)
        assert all(np.array_equal(a, b) for a, b in zip(state, (data.qpos, data.qvel, data.time), strict=True))
        mj.mj_step(model, data)
        assert np.abs(step.problem.velocity(step.impulse) - data.qvel).max() < 1e-9
        touching = sum(contact.efc_address >= 0 for contact in data.contact)
        assert touching >= 8
        assert np.allclose(step.problem.bias[:touching] * step.step, data.contact.dist - data.contact.includemargin)
        found = labels(step.problem)
        assert step.problem.contacts == touching + found["limits"] + found["dry_friction"]
        limits, dry = limits + found["limits"], dry + found["dry_friction"]
        noted |= step.notes.keys()
        mj.mj_step(model, data, 15)
    assert {TORSION, ROLLING, "softness of contacts", "softness of equalities"} <= noted
    assert limits
    assert dry == 6  # of one joint in each of six steps


def test_limits_and_dry_friction_are_rows() -> None:
    """A slider that is driven against its stop, and one that dry friction holds: rows, biases and impulses by hand."""
    slider = '<body pos="0 {at} 0"><joint type="slide" axis="1 0 0" {joint}/><geom size=".1" mass="2"/></body>'
    stop, held = slider.format(at=0, joint='range="-.5 .5" limited="true"'), slider.format(at=1, joint='frictionloss="3"')
    model = mj.MjModel.from_xml_string(f"<mujoco><worldbody>{stop}{held}</worldbody></mujoco>")
    data, h = mj.MjData(model), 0.002
    data.qpos[0], data.qvel[0], data.qfrc_applied[1] = 0.501, 0.5, 2.0
    step = capture.mujoco(model, data)
    problem = step.problem
    assert problem.normal.toarray().tolist() == [[-1, 0], [0, 0]]
    assert problem.tangent.toarray().tolist() == [[0, 0], [0, 0], [0, 1], [0, 0]]
    assert problem.friction.tolist() == [0, 0]
    assert np.allclose(problem.friction_bias, [0, 3 * h])
    assert np.allclose(problem.bias, [-0.001 / h, 1.0])
    assert step.impulse[1, 1] == pytest.approx(-0.9 * 2 * h, rel=1e-9)  # held against 2 N, to MuJoCo's impedance of 0.9
    assert set(step.notes) <= {UNEXPLAINED}
    exact = fb.solve(problem.replace(bias=[0, 1]), "hybrid", tol=1e-12)
    assert np.allclose(problem.velocity(exact.impulse), 0, atol=1e-12)
    assert np.allclose(exact.impulse, [[2 * 0.5, 0, 0], [0, -2 * h, 0]], atol=1e-12)


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_mass_rows_and_free_velocity_are_the_engines(cone) -> None:
    """Against MuJoCo's own mass matrix, contact forces, and step without constraints: none is taken from the next velocity."""
    model, data = fallen(BLOCK.format(cone=cone, extra=""), 60)
    step = capture.mujoco(model, data)
    full, before = np.zeros((6, 6)), data.qvel.copy()
    mj.mj_fullM(model, data, full)
    assert np.allclose(step.problem.mass.toarray(), full, rtol=0, atol=1e-10)
    assert set(step.notes) == {"softness of contacts"}
    mj.mj_step(model, data)
    force = np.zeros((data.ncon, 6))
    for i in range(data.ncon):
        mj.mj_contactForce(model, data, i, force[i])
    assert np.allclose(step.impulse, model.opt.timestep * force[:, :3], rtol=0, atol=1e-13)
    gravity = np.array([0, 0, -9.81, 0, 0, 0])
    spin = before[3:]
    turn = np.linalg.solve(full[3:, 3:], -np.cross(spin, full[3:, 3:] @ spin))
    free = before + model.opt.timestep * (gravity + np.concatenate([np.zeros(3), turn]))
    assert np.allclose(step.problem.free_velocity, free, rtol=0, atol=1e-12)


def test_friction_of_two_coefficients_is_one_with_scaled_rows() -> None:
    pair = '<contact><pair geom1="floor" geom2="box" friction=".8 .2 .01 .001 .001"/></contact>'
    xml = BLOCK.format(cone="elliptic", extra=pair).replace('type="plane"', 'name="floor" type="plane"')
    model, data = fallen(xml.replace('<geom type="box"', '<geom name="box" type="box"'), 60)
    data.qvel[:2] = 2.0, 1.0
    step = capture.mujoco(model, data)
    mj.mj_step(model, data)
    assert np.abs(step.problem.velocity(step.impulse) - data.qvel).max() < 1e-9
    assert np.allclose(step.problem.friction, 0.8)
    size = np.linalg.norm(step.impulse[:, 1:], axis=1)
    assert (size <= 0.8 * step.impulse[:, 0] * (1 + 1e-6)).all()
    assert size.max() > 0.79 * step.impulse[size.argmax(), 0]  # it slides: the forces are on the cone


def test_steps_without_contacts_and_unusable_ones() -> None:
    model, data = fallen("<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>", 3)
    step = capture.mujoco(model, data)
    assert (step.problem.contacts, step.notes) == (0, {})
    data.qfrc_applied[0] = 1e20
    with pytest.raises(fb.InputError, match="data: MuJoCo resets it: the simulation has diverged"):
        capture.mujoco(model, data)
    model.opt.integrator = mj.mjtIntegrator.mjINT_RK4
    with pytest.raises(fb.InputError, match="integrator: must be Euler, implicit or implicitfast"):
        capture.mujoco(model, data)
    data.qpos[0] = np.nan
    with pytest.raises(fb.InputError, match="data: MuJoCo would reset it"):
        capture.mujoco(model, data)


def test_a_gap_of_rounding_is_none() -> None:
    """A ball that moves only along the floor could not leave it: an overlap of 3e-17 m would have no solution."""
    ball = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><geom size=".1"/>'
    xml = f'<geom type="plane" size="1 1 1" pos="0 0 .7"/><body pos="0 0 {0.7 + 0.1}">{ball}</body>'
    model, data = fallen(f"<mujoco><worldbody>{xml}</worldbody></mujoco>", 1)
    assert -1e-16 < data.contact.dist[0] < 0
    problem = capture.mujoco(model, data).problem
    assert problem.bias.tolist() == [0]
    assert fb.verify(problem, fb.solve(problem, "hybrid"), 1e-8).verdict is fb.Verdict.SOLVED
