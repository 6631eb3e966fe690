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
    mj.mj_step(model, data, 300)
    model.opt.gravity[0] = 4.0  # less than friction holds
    mj.mj_step(model, data, 20)
    path = capture.mujoco(model, data).save(tmp_path)
    found = judge_file(tmp_path, path)
    assert found.contacts == 12
    assert found.law == "dissipation"
    assert 1e-5 < found.creep < 1e-1  # m/s, inside the cone
    assert 1e-6 < found.penetration < 1e-2
    assert found.residual > 100 * found.floor
