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
from studies.study import Array, Row, Study, Summary, Tables, finish, listing, require

REFERENCE, TWIN, MUJOCO, RELAXED = "reference", "twin", "MuJoCo", "relaxation"
TOLERANCES, SWEEPS = (1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10), (1, 4, 10, 50)
WAYS: dict[str, tuple[str, float, int | None]] = {  # solver, tolerance, limit
    REFERENCE: ("hybrid", 1e-12, None),
    TWIN: ("hybrid", 1e-12, None),
    **{f"{tol:.0e}": ("nsgs", tol, None) for tol in TOLERANCES},
    **{f"{sweeps} sweeps": ("nsgs", 1e-12, sweeps) for sweeps in SWEEPS},
    RELAXED: ("relaxation_ip", 1e-10, None),
    MUJOCO: ("", 0.0, None),
}
ROBOTS, TIMES = ("humanoid", "quadruped", "hand_block", "fetch_pick"), (0.1, 0.3)
MOVED = 1e-12  # of the velocities of the twin's start
COMPARABLE = 1e-6  # m or rad, that the twin may be away
HELD = 1.0  # mm: what an object may move that stands or is held
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


def paths(names: Iterable[str] = ROBOTS, seeds: Iterable[int] = (0, 1), duration: float = 0.3) -> Iterator[Row]:
    """Robots under smooth controls: how far each way's coordinates are from the reference's, m or rad."""
    from tools.robots.models import MODELS, begin

    for name in names:
        model = next(one for one in MODELS if one.name == name).load()
        for seed in seeds:
            known: dict[float, Array] = {}
            for way in WAYS:
                data, drive = begin(model, "smooth", seed)
                if way == TWIN:
                    data.qvel[:] += MOVED * np.random.default_rng(seed).normal(size=model.nv)
                for time, q in _moved(model, data, drive, way, duration):
                    if way == REFERENCE:
                        known[time] = q
                    else:
                        yield {
                            "model": name,
                            "seed": seed,
                            "way": way,
                            "time": time,  # s
                            "error": _apart(model, known[time], q),  # the largest of a coordinate, m or rad
                        }


def tasks(names: Iterable[str] = tuple(TASKS), duration: float = 0.3) -> Iterator[Row]:
    """Things that Coulomb's law holds at rest: how far the body moves in the time, mm."""
    import mujoco as mj

    for name in names:
        world, body, forces = TASKS[name]
        xml = f'<mujoco><option cone="elliptic" timestep=".004"/><worldbody>{world}</worldbody></mujoco>'
        for way in WAYS:
            model = mj.MjModel.from_xml_string(xml)
            data = mj.MjData(model)
            for joint, force in forces.items():
                data.joint(joint).qfrc_applied = force
            mj.mj_forward(model, data)
            begin = data.body(body).xpos.copy(), data.body(body).xquat.copy()
            for _ in _moved(model, data, lambda data, k: None, way, duration):
                pass
            mj.mj_forward(model, data)
            there = np.linalg.norm(data.body(body).xpos - begin[0]) + 0.1 * np.linalg.norm(data.body(body).xquat - begin[1])
            yield {"task": name, "way": way, "moved": 1e3 * float(there)}  # mm; a turn counts at a tenth of a metre


def _moved(model: Any, data: Any, drive: Any, way: str, duration: float) -> Iterator[tuple[float, Array]]:
    """At TIMES: the time and the positions; not a number after a divergence."""
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
            yield ends[k + 1], np.full(model.nq, np.nan) if lost else data.qpos.copy()


def _apart(model: Any, a: Array, b: Array) -> float:
    import mujoco as mj

    difference = np.zeros(model.nv)
    mj.mj_differentiatePos(model, difference, 1.0, a, b)
    return float(np.abs(difference).max())


def summary(found: Tables) -> Summary:
    errors, held = found["paths"], found["tasks"]
    twins = errors[errors["way"] == TWIN].groupby("model")["error"].max()
    parted = sorted(twins.index[twins > COMPARABLE])
    errors = errors[~errors["model"].isin(parted)]
    middle = errors.pivot_table(index="way", columns="time", values="error", aggfunc="median")
    worst = errors.pivot_table(index="way", columns="time", values="error", aggfunc="max")
    twin = worst.loc[TWIN]
    tight, loose = f"{TOLERANCES[-2]:.0e}", f"{TOLERANCES[0]:.0e}"
    last = middle.columns.max()
    require(middle.loc[tight, last] < middle.loc[loose, last], "the error falls with the tolerance")
    moved = held.pivot_table(index="way", columns="task", values="moved")
    suffices = {}
    for task in moved:
        fine = [way for way in _tolerances() if moved.loc[way, task] <= HELD]
        suffices[task] = fine[0] if fine else "none"
    numbers = {
        "robots": listing(sorted(twins.index)),
        "parted": listing(parted),
        "parted_by": f"{twins.max():.0e}",
        "seeds": errors["seed"].nunique(),
        "rows": _table(
            pd.DataFrame({f"after {t:g} s": middle[t].map("{:.0e}".format) + worst[t].map(" ({:.0e})".format) for t in middle})
        ),
        "tasks": _table(moved.drop(TWIN).map("{:.1e}".format)),
        "suffices": listing([f"{task} {way}" for task, way in suffices.items()]),
        "twin": f"at most {twin[last]:.0e}",
        "last": f"{last:g}",
        "loose": f"{middle.loc[loose, last]:.0e}",
        "tight": f"{middle.loc[tight, last]:.0e}",
        "cut": f"{middle.loc['10 sweeps', last]:.0e}",
        "relaxed": f"{middle.loc[RELAXED, last]:.0e}",
        "mujoco": f"{middle.loc[MUJOCO, last]:.0e}",
    }
    panels = [
        Panel(f"after {time:g} s", partial(_draw, errors=errors[errors["time"] == time]))
        for time in sorted(errors["time"].unique())
    ]
    return Summary(numbers, {"paths": tuple(panels)})


def _tolerances() -> list[str]:
    return [f"{tol:.0e}" for tol in TOLERANCES]


def _table(cells: pd.DataFrame) -> list[str]:
    """The lines of a table in Markdown, a row for each way."""
    rows = [["", *cells.columns], *([way, *cells.loc[way]] for way in WAYS if way in cells.index)]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return [lines[0].replace("|  |", "| |"), f"|---|{'---|' * len(cells.columns)}", *lines[1:]]


def _draw(ax: Axes, errors: pd.DataFrame) -> None:
    """A line for each model over the tolerance, by the median of its seeds; cut sweeps and laws as marks at the right."""
    marks = [*(f"{sweeps} sweeps" for sweeps in SWEEPS), RELAXED, MUJOCO]
    x = np.arange(len(TOLERANCES) + len(marks))
    for name, own in errors.groupby("model"):
        middle = own.groupby("way")["error"].median()
        line = ax.plot(x[: len(TOLERANCES)], middle.reindex(_tolerances()), "-o", ms=3, lw=1, label=name)[0]
        ax.plot(x[len(TOLERANCES) :], middle.reindex(marks), "s", ms=3, color=line.get_color())
    ax.plot([x[0], x[-1]], [errors.loc[errors["way"] == TWIN, "error"].median()] * 2, ":", color=INK, lw=0.8)
    ax.set_yscale("log")
    ax.set_xticks(x, [*_tolerances(), *marks], rotation=60, ha="right", fontsize=6)
    ax.legend(fontsize=5.5, ncols=2)
    finish(ax, "nsgs: residual; sweeps; other laws", "error, m or rad")


STUDY = Study((paths, tasks), summary, needs=("mujoco", "dm_control", "gymnasium_robotics"))
