"""Exact steps of MuJoCo's models: against closed forms, against mj_step where nothing touches, and on robots."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench import capture

mj = pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco")

BLOCK = """
<mujoco>
  <option cone="{cone}" timestep=".004" integrator="{integrator}"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 .1" friction="{mu}"/>
    <body pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="2" friction="{mu}"/><site name="s" size=".2"/></body>
  </worldbody>
  <sensor><touch site="s"/></sensor>
</mujoco>"""
BALL = """<mujoco><worldbody><geom type="plane" size="1 1 1"/>
<body pos="0 0 .09"><freejoint/><geom size=".1"/></body></worldbody></mujoco>"""
CHAIN = """
<mujoco>
  <option timestep=".005" integrator="{integrator}"/>
  <worldbody>
    <body pos="0 0 2">
      <joint axis="0 1 0" damping=".3"/><geom type="capsule" fromto="0 0 0 .3 0 -.1" size=".02"/>
      <body pos=".3 0 -.1">
        <joint axis="1 1 0" stiffness="2" damping=".2"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
      </body>
    </body>
    <body name="ball" pos="0 1 3"><freejoint/><geom size=".1"/></body>
  </worldbody>
  <actuator><position joint="0" kp="3" kv=".1" timeconst=".1"/></actuator>
</mujoco>""".replace('joint="0"', 'joint="j"').replace('<joint axis="0 1 0"', '<joint name="j" axis="0 1 0"')


def made(xml: str):
    model = mj.MjModel.from_xml_string(xml)
    return model, mj.MjData(model)


@pytest.mark.parametrize(("integrator", "damper"), [("Euler", 1), ("Euler", 0), ("implicitfast", 0), ("implicit", 1)])
def test_without_contacts_the_step_is_mujocos(integrator, damper) -> None:
    model, data = made(CHAIN.format(integrator=integrator))
    model.opt.disableflags = 0 if damper else int(mj.mjtDisableBit.mjDSBL_DAMPER)
    data.qvel[:] = np.arange(model.nv) / 5
    data.ctrl[:] = 0.7
    other = mj.MjData(model)
    mj.mj_copyData(other, model, data)
    for _ in range(20):
        result = fb.mujoco.step(model, data)
        mj.mj_step(model, other)
    assert result.problem.contacts == 0
    for name in ("qpos", "qvel", "act", "time"):
        assert np.allclose(getattr(data, name), getattr(other, name), rtol=0, atol=1e-12), name


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_a_block_slides_to_rest_and_stays(cone, integrator) -> None:
    """v falls by mu g h a step, and rests at zero, where MuJoCo's soft friction creeps; forces and sensors are the step's."""
    mu, h = 0.5, 0.004
    model, data = made(BLOCK.format(cone=cone, integrator=integrator, mu=mu))
    data.qpos[2] -= 1e-9  # touching
    data.qvel[0] = 0.3
    for k, result in enumerate(fb.mujoco.steps(model, data, 25), start=1):
        assert result.residual <= 1e-8
        assert data.qvel[0] == pytest.approx(max(0.3 - k * mu * 9.81 * h, 0.0), abs=1e-7)
        force = np.zeros((data.ncon, 6))
        for i in range(data.ncon):
            mj.mj_contactForce(model, data, i, force[i])
        assert np.allclose(force[:, :3] * h, result.impulse, atol=1e-9)
        assert data.sensordata[0] == pytest.approx(2 * 9.81, rel=1e-6)
        energy = dict(result.energy)
        assert abs(energy["defect"]) < 1e-8
        assert energy["friction"] == pytest.approx(energy["kinetic"], abs=1e-8)


def test_the_velocity_is_that_which_was_solved_for() -> None:
    """MuJoCo's implicitfast would add gyroscopic terms to that of a free body that is no ball and spins."""
    model, data = made(BALL.replace('size=".1"', 'type="box" size=".2 .1 .03"'))
    model.opt.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    data.qvel[:] = [1, 0, -1, 3, 2, 5]
    for result in fb.mujoco.steps(model, data, 60):
        assert np.allclose(data.qvel, result.problem.velocity(result.impulse), rtol=0, atol=1e-12)


def test_an_unknown_integrator_is_refused_by_name() -> None:
    model, data = made(BALL)
    model.opt.integrator = getattr(mj.mjtIntegrator, "mjINT_DISCRETE", 99)
    with pytest.raises(fb.InputError, match=r"^integrator: must be Euler, RK4, implicit or implicitfast"):
        fb.mujoco.step(model, data)


def test_ledger_adds_up_with_everything_at_work() -> None:
    model, data = made(EVERYTHING)
    data.qvel[:] = np.sin(np.arange(model.nv))
    used = dict.fromkeys(("contacts", "friction", "limits", "dry friction", "equalities"), 0.0)
    for result in fb.mujoco.steps(model, data, 250):
        assert result.energy["kinetic"] == pytest.approx(sum(result.energy[name] for name in ("forces", *used)), abs=1e-12)
        used = {name: max(size, abs(result.energy[name])) for name, size in used.items()}
        assert result.residual <= 1e-8
    assert all(used.values())


def test_terms_of_implicit_are_no_work_of_equalities() -> None:
    loose = EVERYTHING.replace("<connect", '<connect active="false"')
    model, data = made(loose.replace("<worldbody>", '<option integrator="implicit"/><worldbody>'))
    data.qvel[:] = 3 * np.sin(np.arange(model.nv))
    assert all(abs(result.energy["equalities"]) < 1e-10 for result in fb.mujoco.steps(model, data, 20))


def test_bodies_asleep_do_not_fall() -> None:
    xml = BLOCK.format(cone="elliptic", integrator="Euler", mu=0.5)
    model, data = made(xml.replace("<worldbody>", '<option><flag sleep="enable"/></option><worldbody>'))
    assert sum(data.ntree_awake for _ in fb.mujoco.steps(model, data, 60)) > 5
    assert data.ntree_awake == 0
    assert not any(use(model, data).problem.free_velocity.any() for use in (capture.mujoco, fb.mujoco.step))


EVERYTHING = """
<mujoco>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body pos="0 0 .5"><freejoint/><geom type="box" size=".1 .1 .1"/>
      <body pos=".1 0 0">
        <joint axis="0 1 0" range="-5 5" limited="true"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".03"/>
        <body name="tip" pos=".3 0 0">
          <joint axis="0 1 0" frictionloss=".05"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".03"/>
        </body>
      </body>
    </body>
    <body name="pendant" pos=".5 .2 .5"><freejoint/><geom size=".05"/></body>
  </worldbody>
  <equality><connect body1="tip" body2="pendant" anchor=".2 0 0"/></equality>
</mujoco>"""


def test_dry_friction_holds_and_a_limit_stops() -> None:
    slider = '<body pos="0 {at} 0"><joint type="slide" axis="1 0 0" {joint}/><geom size=".1" mass="2"/></body>'
    bodies = slider.format(at=0, joint='range="-.5 .5" limited="true"') + slider.format(at=1, joint='frictionloss="3"')
    model, data = made(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    data.qpos[0], data.qvel[0], data.qfrc_applied[:] = 0.499, 0.8, (1.0, 2.9)
    for result in fb.mujoco.steps(model, data, 50):
        assert result.residual <= 1e-8
    assert np.abs(data.qvel).max() < 1e-9
    assert data.qpos[1] == pytest.approx(0, abs=1e-12)
    assert data.qpos[0] == pytest.approx(0.5, abs=2e-4)  # passed by a part of one step, and taken back but for .001 of the size


def test_penetration_is_taken_away_without_momentum() -> None:
    model, data = made(BALL)
    for k, result in enumerate(fb.mujoco.steps(model, data, 20)):
        assert result.penetration == pytest.approx(1e-4 + 0.0099 * 0.8**k, rel=1e-3 * (k + 1))  # to .001 of the mean size
        assert np.abs(data.qvel).max() < 1e-10


def test_what_cannot_be_is_compromised() -> None:
    """A ball wedged between a floor and a ceiling that are too close: it rests in the middle, and every step is solved."""
    model, data = made(BALL.replace("<body", '<geom type="box" size="1 1 .1" pos="0 0 .26"/><body'))
    for result in fb.mujoco.steps(model, data, 60):
        assert result.residual <= 1e-8
        assert np.abs(data.qvel).max() < 1e-9
    assert data.qpos[2] == pytest.approx(0.08, abs=1e-3)


def test_what_nothing_moves_apart_is_left_overlapping() -> None:
    """Two wheels of a car in free fall overlap on their axle, along which none of their velocities goes."""
    wheel = '<body pos="0 {at} 0"><joint axis="0 1 0"/><geom size=".1"/></body>'
    car = f'<body><freejoint/><geom size=".1"/>{wheel.format(at=0.15)}{wheel.format(at=0.3)}</body>'
    model, data = made(f"<mujoco><worldbody>{car}</worldbody></mujoco>")
    for k, result in enumerate(fb.mujoco.steps(model, data, 10), start=1):
        assert result.problem.contacts == 1
        assert data.qvel == pytest.approx(np.array([0, 0, -9.81 * 0.002 * k, 0, 0, 0, 0, 0]), abs=1e-12)


def test_rows_of_rounding_constrain_nothing() -> None:
    """A four-bar linkage that moves in a plane: across the plane its equation has only what rounding leaves."""
    link = '<joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".01" contype="0" conaffinity="0"/>'
    last = f'<body name="last" pos=".3 0 0" euler="0 120 0">{link}</body>'
    bars = f'<body euler="180 33 0">{link}<body pos=".3 0 0" euler="0 20 0">{link}{last}</body></body>'
    loop = '<equality><connect body1="last" body2="world" anchor=".3 0 0"/></equality>'
    model, data = made(f"<mujoco><worldbody>{bars}</worldbody>{loop}</mujoco>")
    problem = fb.mujoco.problem(model, data)
    assert 0 < np.abs(data.efc_J.reshape(3, 3)[1]).max() < 1e-15
    assert np.diff(problem.joints.indptr).tolist() == [3, 3]
    assert np.abs(problem.velocity(np.zeros((0, 3)))).max() > 0.01  # rad/s after a step


def test_a_loop_of_welds_turns_although_a_part_is_out_of_place() -> None:
    parts = "".join(f'<body name="{k}" pos="{x} 0 0"><freejoint/><geom size=".1"/></body>' for x, k in enumerate("abc", -1))
    welds = "".join(f'<weld body1="{one}" body2="{other}"/>' for one, other in ("ab", "bc", "ac"))
    free = f'<option gravity="0 0 0"/><worldbody>{parts}</worldbody>'
    model, data = made(f"<mujoco>{free}<equality>{welds}</equality></mujoco>")
    data.qpos[8], data.qvel[1::6], data.qvel[5::6] = 0.01, (-1, 0, 1), 1
    for _ in fb.mujoco.steps(model, data, 40):
        assert data.qvel[5::6] == pytest.approx(1, abs=0.01)


def test_two_coefficients_of_friction_may_be_far_apart() -> None:
    """A block stops at once in the direction of 10, and slides on in that of 1e-5."""
    pair = '<contact><pair geom1="floor" geom2="block" friction="1e-5 10 .01 .001 .001"/></contact></mujoco>'
    xml = BLOCK.format(cone="elliptic", integrator="Euler", mu=1).replace('<geom type="box"', '<geom name="block" type="box"')
    model, data = made(xml.replace("</mujoco>", pair))
    data.qpos[2] -= 1e-9  # touching
    data.qvel[:2] = 0.03
    for k, result in enumerate(fb.mujoco.steps(model, data, 10), start=1):
        assert result.status is fb.Status.SOLVED
        assert sorted(data.qvel[:2]) == pytest.approx([0.0, 0.03 - k * 1e-5 * 9.81 * 0.004], abs=3e-8)


def test_warm_starts_follow_geoms_and_joints(monkeypatch) -> None:
    model, data = made(EVERYTHING)
    starts, solve = [], fb.mujoco.solve
    monkeypatch.setattr(fb.mujoco, "solve", lambda *problem, **how: starts.append(how["start"]) or solve(*problem, **how))
    before = None
    for _ in range(400):
        result = fb.mujoco.step(model, data, before=before)
        if before is not None and before.problem.contacts > 1 and before.memory.keys() == result.memory.keys():
            assert np.linalg.norm(starts[-1], axis=1) == pytest.approx(np.linalg.norm(before.impulse, axis=1), abs=1e-12)
        before = result
    assert np.linalg.norm(starts[-1] - before.impulse) < 1e-2 * np.linalg.norm(before.impulse)  # nearly at rest


def test_unusable_models_and_states() -> None:
    model, data = made(CHAIN.format(integrator="Euler"))
    model.dof_dampingpoly[0] = 1.0
    with pytest.raises(fb.InputError, match="dof_dampingpoly: Euler takes damping as linear"):
        fb.mujoco.step(model, data)
    model, data = made(BLOCK.format(cone="elliptic", integrator="Euler", mu=0.5))
    data.qfrc_applied[0] = np.inf
    with pytest.raises(fb.InputError, match="data: masses, forces or velocities are not finite"):
        fb.mujoco.step(model, data)
    data.qvel[0] = 1.1e10
    with pytest.raises(fb.InputError, match="data: MuJoCo would reset it: the simulation has diverged"):
        fb.mujoco.step(model, data)
    for named, given in ("model", (data, model)), ("data", (model, made(CHAIN.format(integrator="Euler"))[1])):
        for call in (fb.mujoco.step, fb.capture.mujoco):
            with pytest.raises(fb.InputError, match=f"{named}: must be a mujoco.Mj"):
                call(*given)
    with pytest.raises(fb.InputError, match="model: has no joints"):
        fb.mujoco.step(*made("<mujoco/>"))
    model, data = made(CHAIN.format(integrator="implicit"))
    data.qvel[:] = 1e4
    with pytest.raises(fb.InputError, match="integrator: implicit's mass is not positive definite"):
        fb.mujoco.step(model, data)


@pytest.mark.slow  # six robots; the quick tests have no meshes, tendons or many joints at once
@pytest.mark.parametrize("name", ["humanoid", "dog", "quadruped", "stacker", "hand_block", "fetch_pick"])
def test_robots_step_in_closed_loop(name) -> None:
    pytest.importorskip("tools.robots.models")
    from tools.robots.models import MODELS, begin

    robot = next(one for one in MODELS if one.name == name)
    try:
        model = robot.load()
    except fb.InputError as missing:
        pytest.skip(str(missing))
    data, drive = begin(model, "smooth", 0)
    before = None
    for k in range(100):
        drive(data, k)
        before = fb.mujoco.step(model, data, before=before)
        assert before.residual <= 1e-8
    assert np.isfinite(data.qpos).all()
