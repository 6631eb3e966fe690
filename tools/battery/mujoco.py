"""MuJoCo: with default settings, and with the stiffest settings that its documentation names."""

from importlib import import_module
from typing import Any

import numpy as np
from scipy.optimize import brentq

from tools.battery.world import Array, Setting, gravity

# From the chapter "Modeling", sections on solver parameters and on slip: elliptic cones, a large impratio and noslip iterations
# against slip; the least time constant of solref, twice the step; the impedance of solimp close to 1.
STIFF = 'cone="elliptic" impratio="100" noslip_iterations="20" tolerance="1e-12"'


def stiff(setting: Setting, step: float) -> "MuJoCo":
    """Use the stiffest documented settings."""
    return MuJoCo(setting, step, STIFF, f'solref="{2 * step} 1" solimp=".99 .99 .001"')


class MuJoCo:
    """A setting as MJCF: planes and free bodies, with MuJoCo's defaults except for the step."""

    def __init__(self, setting: Setting, step: float, option: str = "", contact: str = "") -> None:
        contact = contact if setting.restitution is None else _bouncing(setting.restitution)
        self._mj: Any = import_module("mujoco")
        gravity = " ".join(map(str, setting.gravity))
        self._model = self._mj.MjModel.from_xml_string(f"""
            <mujoco>
              <compiler angle="radian"/>
              <option timestep="{step}" gravity="{gravity}" {option}/>
              <default><geom friction="{setting.friction} 0 0" {contact}/></default>
              <worldbody>{_floors(setting)}{_bodies(setting)}</worldbody>
            </mujoco>""")
        self._data = self._mj.MjData(self._model)
        for k, body in enumerate(setting.bodies):
            self._data.qvel[6 * k : 6 * k + 6] = [*body.velocity, *body.spin]

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / self._model.opt.timestep)):
            self._mj.mj_step(self._model, self._data)

    def tilt(self, slope: float) -> None:
        self._model.opt.gravity[:] = gravity(slope)

    def position(self, body: int) -> Array:
        return np.array(self._data.qpos[7 * body : 7 * body + 3])

    def velocity(self, body: int) -> Array:
        return np.array(self._data.qvel[6 * body : 6 * body + 3])


def _bouncing(e: float) -> str:
    """Return the solref for restitution e: the default time constant of 20 ms and the damping ratio with which a spring and
    damper rebound at e times the speed, or no damping for e = 1, as soft as contacts over several steps need. A spring that
    does not pull rebounds at some speed for any damping: at 0.03 % with a ratio of 30, which is used for e = 0."""
    if e in (0, 1):
        return 'solref="-5000 0"' if e else 'solref="0.02 30"'
    return f'solref="0.02 {brentq(lambda ratio: _rebound(ratio) - e, 1e-9, 0.7)}"'


def _rebound(ratio: float) -> float:
    """Return the speed of a mass leaving a spring with this damping ratio over its speed of approach. It leaves when the total
    force vanishes, before the spring has its rest length again, since a contact does not pull."""
    root = np.sqrt(1 - ratio**2)
    return float(np.exp(-ratio / root * (np.pi - np.arctan2(2 * ratio * root, 1 - 2 * ratio**2))))


def _floors(setting: Setting) -> str:
    return "".join(f'<geom type="plane" size="50 50 1" euler="{turn} 0 0"/>' for turn in setting.floors)


def _bodies(setting: Setting) -> str:
    text = ""
    for body in setting.bodies:
        kind = "sphere" if len(body.size) == 1 else "box"
        size, at = (" ".join(map(str, v)) for v in (body.size, body.position))
        geom = f'<geom type="{kind}" size="{size}" mass="{body.mass}"/>'
        text += f'<body pos="{at}" euler="{body.turn} 0 0"><freejoint/>{geom}</body>'
    return text
