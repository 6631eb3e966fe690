"""How exact must a step be? Paths and simple tasks of MuJoCo's models against tolerances, sweeps cut short, and other laws."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import velocity_distance
from frictionbench.reports.drawing.figures import Panel
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, listing, require

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
DURATION = 0.3  # s
HANDS = ("adroit_relocate", "hand_block", "hand_egg", "hand_pen")
ROBOTS = ("humanoid", "humanoid_CMU", "quadruped", "hopper", "walker", "cheetah", "ant", "fetch_slide", *HANDS)
QUICK, SEEDS = ("humanoid", "quadruped", "hopper", "walker", "cheetah", "ant"), (1, 2, 3, 4)
MOVED = 1e-12  # change of the velocities at the twin's start
COMPARABLE = 1e-6  # largest distance of exact paths that are the same, m, and of velocities, relative to their change
HELD = 1.0  # largest displacement of an object that stands or is held, mm
TOWER = "".join(
    f'<body name="b{k}" pos="0 0 {0.05 + 0.1 * k}"><freejoint/><geom type="box" size=".05 .05 .05" mass="{mass}"/></body>'
    for k, mass in enumerate((1, 1, 1, 1, 10))
)
FINGER = (
    '<body pos="{x} 0 .5" gravcomp="1"><joint name="{n}" type="slide" axis="{a} 0 0"/>'
    '<geom type="box" size=".01 .03 .03" friction=".8"/></body>'
)
PRESS = 8.0  # force on the slides of fingers, N
TASKS = {  # scene, and the body that must not move
    "tower": ('<geom type="plane" size="1 1 1" friction=".6"/>' + TOWER, "b4"),
    "grasp": (
        FINGER.format(x=-0.061, n="left", a=1)
        + FINGER.format(x=0.061, n="right", a=-1)
        + '<body name="held" pos="0 0 .5"><freejoint/><geom type="box" size=".05 .05 .05" mass="1" friction=".8"/></body>',
        "held",
    ),
    "slope": (
        '<geom type="plane" size="9 9 1" zaxis=".4794 0 .8776" friction=".6"/>'
        '<body name="s" pos=".0479 0 .0878" euler="0 28.65 0"><freejoint/>'
        '<geom type="box" size=".1 .1 .1" friction=".6"/></body>',
        "s",
    ),
    "hinge": (
        '<body name="h" pos="0 0 1"><joint name="j" axis="0 1 0" frictionloss="1"/><geom type="capsule" fromto="0 0 0 .5 0 0" '
        'size=".02" mass=".35"/></body>',
        "h",
    ),
}


def paths(
    names: Iterable[str] = ROBOTS, duration: float = DURATION, seeds: Iterable[int] = (0,), ways: Iterable[str] = tuple(WAYS)
) -> Iterator[Row]:
    """Robots under smooth controls: the distance of each way's bodies from the reference's at the end.

    ways: the reference is the first. The steps of its path are also solved from zero by two methods.
    """
    for name, seed in product(names, seeds):
        known: Array | None = None
        met: list[fb.FrictionProblem] = []
        for way in ways:
            model, data, drive = _driven(name, seed)
            if way == TWIN:
                data.qvel[:] += MOVED * np.random.default_rng(0).normal(size=model.nv)
            centres = _moved(model, data, drive, way, duration, met if way == REFERENCE else None)
            known = centres if known is None else known
            error = float(np.linalg.norm(centres - known, axis=1).max())  # of a body, m
            yield {"model": name, "seed": seed, "way": way, "error": error} | (_facts(met) if way == REFERENCE else {})


def others(names: Iterable[str] = QUICK, duration: float = DURATION, seeds: Iterable[int] = SEEDS) -> Iterator[Row]:
    """The same by other seeds, which change the first velocities and the controls."""
    return paths(names, duration, seeds, (REFERENCE, TWIN, *SOLVED, "10 sweeps"))


def _facts(met: list[fb.FrictionProblem]) -> Row:
    """Return how many steps there are, how many have friction at a contact, and how many two answers from zero."""
    answers = [[fb.solve(problem, WAYS[way][0], tol=1e-12).impulse for way in (REFERENCE, OTHER)] for problem in met]
    judged = list(zip(met, answers, strict=True))
    apart = np.array([velocity_distance(problem, *pair) or 0.0 for problem, pair in judged])  # over the change by contact
    return {
        "steps": len(met),
        "residual": max(fb.residual(problem, r) for problem, pair in judged for r in pair),
        "frictional": sum((problem.friction > 0).any() for problem in met),
        "several": int((apart > COMPARABLE).sum()),
        "apart": apart.max(),
    }


def tasks(names: Iterable[str] = tuple(TASKS), duration: float = DURATION) -> Iterator[Row]:
    """Objects that are at rest by Coulomb's law: the displacement of the body's centre over the duration, mm."""
    for name in names:
        for way in WAYS:
            model, data = _built(name)
            body = model.body(TASKS[name][1]).id
            begin = data.xipos[body].copy()
            centres = _moved(model, data, lambda data, k: None, way, duration)
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

    scene = f'<mujoco><option cone="elliptic" timestep=".004"/><worldbody>{TASKS[task][0]}</worldbody></mujoco>'
    model = mj.MjModel.from_xml_string(scene)
    data = mj.MjData(model)
    data.qfrc_applied[model.jnt_dofadr[model.jnt_type == mj.mjtJoint.mjJNT_SLIDE]] = PRESS
    mj.mj_forward(model, data)
    return model, data


def _driven(name: str, seed: int) -> tuple[Any, Any, Any]:
    """Return a robot's model, its data at the start, and its smooth controls."""
    from tools.robots.models import MODELS, begin

    model = next(one for one in MODELS if one.name == name).load()
    return model, *begin(model, "smooth", seed)


def _moved(model: Any, data: Any, drive: Any, way: str, duration: float, met: list[fb.FrictionProblem] | None = None) -> Array:
    """Return the bodies' centres of mass (nbody, 3) after the duration, m; note the problems met."""
    import mujoco as mj

    (solver, tol, limit), before = WAYS[way], None
    for k in range(round(duration / model.opt.timestep)):
        drive(data, k)
        if met is not None:
            met.append(fb.mujoco.problem(model, data))
        if way == MUJOCO:
            mj.mj_step(model, data)
        else:
            before = fb.mujoco.step(model, data, solver, tol, before, limit)
    mj.mj_kinematics(model, data)
    return np.array(data.xipos)


def summary(tables: Tables) -> Summary:
    first, grips, others = tables["paths"], tables["grips"], tables["others"]
    met = first[first["way"] == REFERENCE].set_index("model")
    ends = first.pivot_table(index="way", columns="model", values="error", sort=False).drop(REFERENCE)
    several, unstable = met[met["several"] > 0], ends.columns[ends.loc[TWIN] > COMPARABLE]
    alone = ends.drop(columns=several.index.union(unstable))
    moved = tables["tasks"].pivot_table(index="way", columns="task", values="moved")
    exact = [REFERENCE, OTHER, SOLVED[-1]]
    require((ends.loc["1 sweeps"] > COMPARABLE).all(), "one sweep is not exact on any model")
    require((alone.loc[exact[1:]] < COMPARABLE).all(axis=None), "exact paths agree where no step has several answers")
    require((met["residual"] < TOLERANCES[-1]).all(), "both answers to every step are exact")
    require((moved.loc[exact, "grasp"] > HELD).nunique() == 2, "exact steps hold the grasp and lose it")
    require((grips["residual"] < TOLERANCES[-2]).all(), "every method answers the grasp's step exactly")
    loosest = [f"{task} {next((way for way in SOLVED if moved.loc[way, task] <= HELD), 'none')}" for task in moved]
    again = others.pivot_table(index="way", columns=["model", "seed"], values="error", sort=False)
    shown = others[others["several"] > 0].set_index(["model", "seed"]).index
    near = again.loc[:, (again.loc[TWIN] < COMPARABLE) & ~again.columns.isin(shown)].drop(REFERENCE)
    clear = near.loc[:, near.loc[SOLVED[-1]] < COMPARABLE]
    hidden = near.columns.difference(clear.columns)
    numbers = {
        "more": [again.columns.size, near.columns.size, clear.columns.size],
        "seeds": len(SEEDS),
        "quick": listing(list(QUICK)),
        "shown": listing([f"{model} by seed {seed}" for model, seed in shown]),
        "hidden": listing([f"{model} by seed {seed} ({near[model, seed].drop(TWIN).min():.0e} m)" for model, seed in hidden]),
        "often": {way: f"{count} of {clear.columns.size}" for way, count in (clear > HELD / 1e3).sum(axis=1).items()},
        "most": clear.max(axis=1).map("{:.0e}".format).to_dict(),
        "spread": _table(clear.T.groupby("model", sort=False).agg(_range).T),
        "alone": alone.columns.size,
        "names": listing(list(alone.columns)),
        "several": listing(list(several.index)),
        "unstable": listing([f"{name} ({ends.loc[TWIN, name]:.0e} m)" for name in unstable]),
        "splits": listing(
            [f"{row.several:g} of {row.steps:g} of {row.Index} (by {100 * row.apart:.0f} %)" for row in several.itertuples()]
        ),
        "smooth": listing(list(met.index[met["frictional"] == 0])),
        "twin": f"{alone.loc[TWIN].max():.0e}",
        "split": listing([f"{ends.loc[OTHER, name]:.0e} m in {name}" for name in several.index]),
        "rows": _table(alone.map("{:.0e}".format)),
        "apart": _table(ends.drop(columns=alone.columns).map("{:.0e}".format)),
        "last": f"{DURATION:g}",
        "far": {way: f"{count} of {alone.columns.size}" for way, count in (alone > HELD / 1e3).sum(axis=1).items()},
        "worst": alone.max(axis=1).map("{:.0e}".format).to_dict(),
        "slip": f"{moved.loc[REFERENCE, 'grasp']:.1f}",
        "tasks": _table(moved.drop(TWIN).map("{:.1e}".format)),
        "loosest": listing(loosest),
        "grips": grips.to_dict("records"),
    }
    groups = {"one path": alone, "several, or unstable": ends.drop(columns=alone.columns)}
    return Summary(numbers, {"paths": (Panel(f"after {DURATION:g} s", partial(_draw, groups=groups)),)})


def _table(cells: pd.DataFrame) -> list[str]:
    """Return the lines of a Markdown table with a row for each way."""
    rows = [["", *cells.columns], *([way, *cells.loc[way]] for way in WAYS if way in cells.index)]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return [lines[0].replace("|  |", "| |"), f"|---|{'---|' * len(cells.columns)}", *lines[1:]]


def _range(errors: pd.Series) -> str:
    return f"{errors.min():.0e} to {errors.max():.0e}"


def _draw(ax: Axes, groups: dict[str, pd.DataFrame]) -> None:
    """Plot a dot for each model."""
    for k, (label, errors) in enumerate(groups.items()):
        x = np.repeat(np.arange(len(errors)), errors.columns.size)
        curve(ax, k, x, errors.to_numpy().ravel(), label, ls="", alpha=0.6)
    ax.set_xticks(range(len(errors)), errors.index, rotation=60, ha="right", fontsize=6)
    finish(ax, "nsgs: residual; sweeps; other laws", "error, m", "y")


STUDY = Study((paths, others, tasks, grips), summary, needs=("mujoco", "dm_control", "gymnasium_robotics"))
