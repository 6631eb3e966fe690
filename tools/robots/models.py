"""The models of robots, and the behaviours that distinguish their motions.

A behaviour sets controls and forces before each step. All are random with a fixed seed:

    settle    no control
    fall      no control, thrown from a height of up to half the model's size with random velocities
    smooth    sines of 0.5 to 3 Hz with half of each control's range as amplitude
    harsh     new controls from their whole ranges in every tenth step
    hit       no control; in every fiftieth step a random body is pushed for five steps, by up to five times the model's weight
    grasp     controls that close within 0.3 s and oscillate; mocap bodies drift
"""

from collections.abc import Callable
from importlib import metadata
from typing import Any, NamedTuple

import mujoco as mj
import numpy as np

from frictionbench.problems import InputError

Array = np.ndarray[Any, Any]
Drive = Callable[[Any, int], None]  # arguments: data and the number of the step
ALL = ("settle", "fall", "smooth", "harsh", "hit")


class Model(NamedTuple):
    """file: the end of its path in the package. bare: whether it has no floor and is fixed to the world, so that it gets a
    floor and a free joint. step: replaces the model's own, s."""

    name: str
    package: str
    file: str
    behaviours: tuple[str, ...] = ALL
    bare: bool = False
    step: float | None = None

    def load(self) -> Any:
        """Return the mujoco.MjModel. Errors: InputError naming the package or file that is missing."""
        return load(self.package, self.file, self.bare, self.step)


def _suite(name: str, **more: Any) -> Model:
    return Model(name, "dm_control", f"suite/{name}.xml", **more)


def _farama(name: str, file: str, **more: Any) -> Model:
    return Model(name, "gymnasium-robotics", f"envs/assets/{file}.xml", **more)


HANDS = (*ALL, "grasp")
MODELS = (
    *(_suite(name) for name in ("humanoid", "humanoid_CMU", "quadruped", "dog", "hopper", "walker", "cheetah", "ball_in_cup")),
    *(_suite(name, behaviours=HANDS) for name in ("stacker", "manipulator", "finger")),
    Model("rodent", "dm_control", "walkers/assets/rodent.xml", bare=True),
    Model("fruit_fly", "dm_control", "fruitfly_v2/floor.xml"),
    Model("ant", "dm_control", "third_party/ant/ant.xml", bare=True),
    Model("humanoid_20ms", "dm_control", "suite/humanoid.xml", step=0.02),
    *(_farama(f"hand_{name}", f"hand/manipulate_{name}", behaviours=HANDS) for name in ("block", "egg", "pen")),
    *(
        _farama(f"adroit_{name}", f"adroit_hand/adroit_{name}", behaviours=HANDS)
        for name in ("door", "hammer", "pen", "relocate")
    ),
    _farama("kitchen", "kitchen_franka/kitchen_assets/kitchen_env_model", behaviours=HANDS),
    _farama("fetch_pick", "fetch/pick_and_place", behaviours=HANDS),
    _farama("fetch_slide", "fetch/slide", behaviours=HANDS),
)


def load(package: str, file: str, bare: bool = False, step: float | None = None) -> Any:
    """Return the mujoco.MjModel of the file of an installed package whose path ends with `file`. Errors: InputError."""
    try:
        files = metadata.files(package) or []
    except metadata.PackageNotFoundError:
        raise InputError(f"{package}: is not installed: pip install --no-deps {package}") from None
    found = [one for one in files if str(one).endswith(file)]
    if not found:
        raise InputError(f"{package}: holds no {file}")
    return compiled(mj.MjSpec.from_file(str(found[0].locate())), bare, step)


def compiled(spec: Any, bare: bool, step: float | None = None) -> Any:
    """Return the mujoco.MjModel of a mujoco.MjSpec; see Model. Errors: ValueError from MuJoCo."""
    if bare:
        spec.worldbody.add_geom(type=mj.mjtGeom.mjGEOM_PLANE, size=[10, 10, 0.1])
        if not any(joint.type == mj.mjtJoint.mjJNT_FREE for joint in spec.joints):
            spec.worldbody.first_body().add_freejoint()
    if step is not None:
        spec.option.timestep = step
    model = spec.compile()
    if model.opt.integrator == mj.mjtIntegrator.mjINT_RK4:
        model.opt.integrator = mj.mjtIntegrator.mjINT_EULER
    return model


def begin(model: Any, behaviour: str, seed: int) -> tuple[Any, Drive]:
    """Return data at the behaviour's start, and the function to call before each step."""
    random, data = np.random.default_rng(seed), mj.MjData(model)
    if model.nkey:
        mj.mj_resetDataKeyframe(model, data, 0)
    mj.mj_forward(model, data)
    free = model.jnt_qposadr[model.jnt_type == mj.mjtJoint.mjJNT_FREE]
    if behaviour == "fall":
        data.qpos[free + 2] += 0.5 * model.stat.extent * random.uniform(0.2, 1, len(free))
        data.qvel[:] = random.normal(size=model.nv)
    else:
        data.qvel[:] = 0.01 * random.normal(size=model.nv)
    return data, _drive(model, behaviour, random)


def _drive(model: Any, behaviour: str, random: np.random.Generator) -> Drive:
    h, nu = model.opt.timestep, model.nu
    limited = model.actuator_ctrllimited.astype(bool)
    low, high = (
        np.where(limited, side, default) for side, default in zip(model.actuator_ctrlrange.T, (-1.0, 1.0), strict=True)
    )
    middle, half = (low + high) / 2, (high - low) / 2
    rate, phase = random.uniform(0.5, 3, nu), random.uniform(0, 2 * np.pi, nu)
    drift = random.normal(size=(model.nmocap, 3))
    weight = 9.81 * model.body_mass.sum()

    def drive(data: Any, k: int) -> None:
        if behaviour == "smooth":
            data.ctrl[:] = middle + half / 2 * np.sin(2 * np.pi * rate * h * k + phase)
        elif behaviour == "harsh" and k % 10 == 0:
            data.ctrl[:] = random.uniform(low, high)
        elif behaviour == "grasp":
            data.ctrl[:] = middle + half * (0.9 * min(1.0, h * k / 0.3) + 0.1 * np.sin(2 * np.pi * rate * h * k + phase))
            data.mocap_pos[:] += h * 0.1 * drift * np.sin(2 * np.pi * h * k)
        elif behaviour == "hit":
            if k % 50 == 0:
                data.xfrc_applied[random.integers(1, model.nbody), :3] = weight * random.uniform(-5, 5, 3)
            if k % 50 == 5:
                data.xfrc_applied[:] = 0

    return drive
