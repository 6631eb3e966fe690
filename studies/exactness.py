"""How exact must a step be? Paths and simple tasks of MuJoCo's models against tolerances, sweeps cut short, and other laws."""

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, listing, middle, require

REFERENCE, TWIN, OTHER, MUJOCO, RELAXED = "reference", "twin", "interior point", "MuJoCo", "relaxation"
TOLERANCES, SWEEPS = (1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10), (1, 4, 10, 50)
SOLVED = tuple(f"{tol:.0e}" for tol in TOLERANCES)  # ways
WAYS: dict[str, tuple[str, float, int | None]] = {  # solver, tolerance, limit
    REFERENCE: ("hybrid", 1e-12, None),
    TWIN: ("hybrid", 1e-12, None),
    OTHER: ("interior_point", 1e-10, None),
    **{way: ("nsgs", tol, None) for way, tol in zip(SOLVED, TOLERANCES, strict=True)},
    **{f"{sweeps} sweeps": ("nsgs", 1e-12, sweeps) for sweeps in SWEEPS},
    RELAXED: ("relaxation_ip", 1e-10, None),
    MUJOCO: ("", 0.0, None),
}
TIMES = (0.1, 0.3)  # s
HANDS = ("hand_block", "hand_egg")
ROBOTS = ("humanoid", "humanoid_CMU", "quadruped", "hopper", "walker", "cheetah", "ball_in_cup", "finger", "ant", *HANDS)
MOVED = 1e-12  # change of the velocities at the twin's start
COMPARABLE = 1e-6  # largest distance of the twin, m
HELD = 1.0  # largest displacement of an object that stands or is held, mm
TOWER = "".join(
    f'<body name="b{k}" pos="0 0 {0.05 + 0.1 * k}"><freejoint/><geom type="box" size=".05 .05 .05" mass="{mass}"/></body>'
    for k, mass in enumerate((1, 1, 1, 1, 10))
)
FINGER = (
    '<body pos="{x} 0 .5" gravcomp="1"><joint name="{n}" type="slide" axis="{a} 0 0"/>'
    '<geom type="box" size=".01 .03 .03" friction=".8"/></body>'
)
TASKS = {  # scene, body that must not move, forces by joint
    "tower": ('<geom type="plane" size="1 1 1" friction=".6"/>' + TOWER, "b4", {}),
    "grasp": (
        FINGER.format(x=-0.061, n="left", a=1)
        + FINGER.format(x=0.061, n="right", a=-1)
        + '<body name="held" pos="0 0 .5"><freejoint/><geom type="box" size=".05 .05 .05" mass="1" friction=".8"/></body>',
        "held",
        {"left": 8.0, "right": 8.0},
    ),
    "slope": (
        '<geom type="plane" size="9 9 1" zaxis=".4794 0 .8776" friction=".6"/>'
        '<body name="s" pos=".0479 0 .0878" euler="0 28.65 0"><freejoint/>'
        '<geom type="box" size=".1 .1 .1" friction=".6"/></body>',
        "s",
        {},
    ),
    "hinge": (
        '<body name="h" pos="0 0 1"><joint name="j" axis="0 1 0" frictionloss="1"/><geom type="capsule" fromto="0 0 0 .5 0 0" '
        'size=".02" mass=".35"/></body>',
        "h",
        {},
    ),
}


def paths(names: Iterable[str] = ROBOTS, duration: float = 0.3) -> Iterator[Row]:
    """Robots under smooth controls: the distance of each way's bodies from the reference's."""
    from tools.robots.models import MODELS, begin

    for name in names:
        model, known = next(one for one in MODELS if one.name == name).load(), dict[float, Array]()
        for way in WAYS:
            data, drive = begin(model, "smooth", 0)
            if way == TWIN:
                data.qvel[:] += MOVED * np.random.default_rng(0).normal(size=model.nv)
            for time, centres in _moved(model, data, drive, way, duration):
                if way == REFERENCE:
                    known[time] = centres
                else:
                    error = float(np.linalg.norm(centres - known[time], axis=1).max())  # the largest of a body's centre, m
                    yield {"model": name, "way": way, "time": time, "error": error}


def tasks(names: Iterable[str] = tuple(TASKS), duration: float = 0.3) -> Iterator[Row]:
    """Objects that are at rest by Coulomb's law: the displacement of the body's centre over the duration, mm."""
    for name in names:
        for way in WAYS:
            model, data = _built(name)
            body = model.body(TASKS[name][1]).id
            begin = data.xipos[body].copy()
            *_, (_, centres) = _moved(model, data, lambda data, k: None, way, duration)
            yield {"task": name, "way": way, "moved": 1e3 * float(np.linalg.norm(centres[body] - begin))}


def grips(steps: int = 10, solvers: Iterable[str] = ("interior_point", "admm_coulomb", "nsgs", "hybrid")) -> Iterator[Row]:
    """Answers of several methods to one step of the grasp, after steps by the interior point method."""
    model, data = _built("grasp")
    *_, _ = fb.mujoco.steps(model, data, steps, "interior_point", TOLERANCES[-1])
    problem = fb.mujoco.problem(model, data)
    for solver in solvers:
        r = fb.solve(problem, solver, tol=TOLERANCES[-1]).impulse
        face = r[problem.friction > 0, 0].reshape(2, -1)  # the normal impulses of each finger's contacts
        yield {
            "solver": solver,
            "residual": fb.residual(problem, r),  # of Coulomb's law
            "turning": float(np.linalg.norm(problem.velocity(r)[model.body("held").dofadr[0] + 3 :][:3])),  # of the box, rad/s
            "corner": float((face.max(axis=1) / face.sum(axis=1)).max()),  # the largest share of a face's load at one contact
        }


def _built(task: str) -> tuple[Any, Any]:
    """Return the model of a task, and its data at the start."""
    import mujoco as mj

    world, _, forces = TASKS[task]
    model = mj.MjModel.from_xml_string(
        f'<mujoco><option cone="elliptic" timestep=".004"/><worldbody>{world}</worldbody></mujoco>'
    )
    data = mj.MjData(model)
    for joint, force in forces.items():
        data.joint(joint).qfrc_applied = force
    mj.mj_forward(model, data)
    return model, data


def _moved(model: Any, data: Any, drive: Any, way: str, duration: float) -> Iterator[tuple[float, Array]]:
    """Yield at TIMES the time and the bodies' centres of mass (nbody, 3), m; NaN after a divergence."""
    import mujoco as mj

    solver, tol, limit = WAYS[way]
    before, h, lost = None, float(model.opt.timestep), False
    ends = {max(1, round(time / h)): time for time in TIMES if time <= duration * 1.001}
    for k in range(max(ends)):
        drive(data, k)
        try:
            if way == MUJOCO:
                mj.mj_step(model, data)
            elif not lost:
                before = fb.mujoco.step(model, data, solver, tol, before, limit)
        except fb.InputError:
            lost = True
        if k + 1 in ends:
            mj.mj_kinematics(model, data)
            yield ends[k + 1], data.xipos * (np.nan if lost else 1.0)


def summary(tables: Tables) -> Summary:
    errors, grips = tables["paths"], tables["grips"]
    twins = errors[errors["way"] == TWIN].groupby("model")["error"].max()
    parted = twins[twins > COMPARABLE]
    errors = errors[~errors["model"].isin(parted.index)]
    cells = errors.groupby(["way", "time"])["error"].agg(middle).unstack()  # noqa: PD010
    last = errors["time"].max()
    ends = errors[errors["time"] == last].pivot_table(index="way", columns="model", values="error")
    falling = ends.loc[SOLVED[-2]] < ends.loc[SOLVED[0]]
    moved = tables["tasks"].pivot_table(index="way", columns="task", values="moved")
    exact = [REFERENCE, OTHER, SOLVED[-1]]
    require(
        (moved.loc[exact, "grasp"] > HELD).any() and (moved.loc[exact, "grasp"] <= HELD).any(), "exact steps hold and lose it"
    )
    require((grips["residual"] < TOLERANCES[-2]).all(), "every method answers the grasp's step exactly")
    loosest = {task: next((way for way in SOLVED if moved.loc[way, task] <= HELD), "none") for task in moved}
    numbers = {
        "models": ends.columns.size,
        "names": listing(sorted(twins.index)),
        "parted": listing([f"{name} ({away:.0e} m)" for name, away in parted.items()]),
        "other": listing([f"{name} ({away:.0e} m)" for name, away in ends.loc[OTHER].items() if away > COMPARABLE]),
        "twin": f"{twins[twins <= COMPARABLE].max():.0e}",
        "rows": _table(cells.rename(columns="after {:g} s".format).map(str)),
        "last": f"{last:g}",
        "ends": cells[last].to_dict(),
        "far": (ends > HELD / 1e3).sum(axis=1).to_dict(),
        "falling": f"{falling.sum()} of {falling.size}",
        "slip": f"{moved.loc[REFERENCE, 'grasp']:.1f}",
        "tasks": _table(moved.drop(TWIN).map("{:.1e}".format)),
        "loosest": listing([f"{task} {way}" for task, way in loosest.items()]),
        "grips": grips.to_dict("records"),
    }
    panels = [Panel(f"after {time:g} s", partial(_draw, errors=group)) for time, group in errors.groupby("time")]
    return Summary(numbers, {"paths": panels})


def _table(cells: pd.DataFrame) -> list[str]:
    """Return the lines of a Markdown table with a row for each way."""
    rows = [["", *cells.columns], *([way, *cells.loc[way]] for way in WAYS if way in cells.index)]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return [lines[0].replace("|  |", "| |"), f"|---|{'---|' * len(cells.columns)}", *lines[1:]]


def _draw(ax: Axes, errors: pd.DataFrame) -> None:
    """Plot a dot for each model and a dash for the median."""
    found = errors.groupby("way")["error"].agg(list)
    ways = [way for way in WAYS if way in found]
    for x, way in enumerate(ways):
        curve(ax, 0, np.full(len(found[way]), x), found[way], ls="", alpha=0.5)
        ax.plot([x - 0.3, x + 0.3], [np.median(found[way])] * 2, color=INK)
    ax.set_xticks(range(len(ways)), ways, rotation=60, ha="right", fontsize=6)
    finish(ax, "nsgs: residual; sweeps; other laws", "error, m", "y")


STUDY = Study((paths, tasks, grips), summary, needs=("mujoco", "dm_control", "gymnasium_robotics"))
