"""Does the time-stepping scheme converge as the step shrinks? Impulses, velocities and their variation."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import pairwise
from math import atan
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, simulation
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import COLOURS, INK
from studies.motions import by
from studies.study import Row, Study, Summary, Tables, curve, finish, listing, widest

SETTLED_CHANGE = 0.05  # a last change below this share of the quantity counts as convergence
ANOTHER_ANSWER = 0.01  # m/s, or a share of normal impulses: a larger difference is another answer
CHANGE_ROUNDING = 1e-6  # m/s or N s: changes below it are rounding
ROD = 0.9  # N s: the normal impulse that stops the rod in the limit, 3/4 m sin cos |v_t|
SCENES: dict[str, tuple[str, dict[str, Any], float]] = {  # name, settings, duration
    "rod": ("painleve_rod", {"angle": atan(2.0), "friction": 1.6, "tip_velocity": -3.0}, 0.1),
    "jam": ("jam", {"sideways": 0.1}, 0.2),
    "rocking block": ("rocking_block", {}, 0.8),
    "disc in a wedge": ("wedge", {"friction": 0.8}, 0.2),
}
STEPS = (0.01, 0.005, 0.0025, 0.00125, 0.000625)
SOLVERS = ("lemke", "nsgs", "interior_point")


def refinement(
    scenes: Iterable[str] = SCENES, solvers: Iterable[str] = SOLVERS, steps: Iterable[float] = STEPS
) -> Iterator[Row]:
    """Accumulated quantities of each motion by the scheme of Anitescu and Potra, for decreasing steps.

    scene: motion; solver: solves every step to 1e-9; step: s; normal: sum of all normal impulses, N s; largest:
    largest normal impulse, N s; net: sum of J'r, by velocity, N s and N m s; velocity: at the end, m/s and 1/s; variation:
    of the velocity, sum of |v+ - v|_M, root of J.
    """
    for name in scenes:
        generator, settings, duration = SCENES[name]
        for solver in solvers:
            for step in steps:
                stage = fb.scene(generator, **settings, step=step)
                yield {"scene": name, "solver": solver, "step": step, **accumulated(stage, solver, round(duration / step))}


def accumulated(stage: Any, solver: str, steps: int) -> Row:
    """Return sums over the steps of a motion, with velocities in the norm of the mass matrix."""
    states = list(simulation(stage, by(solver, 1e-9), SCHEMES["anitescu_potra"], steps))
    weights, mass = stage.weights, np.sqrt(stage.weights)
    normal, net, largest = 0.0, np.zeros(len(weights)), 0.0
    for after in states[1:]:
        for one in after.solved:
            normal += float(one.impulse[:, 0].sum())
            largest = max(largest, float(one.impulse[:, 0].max(initial=0.0)))
            net = net + one.problem.jacobian.T @ one.impulse.ravel()
    changes = [float(np.linalg.norm(mass * (after.v - before.v))) for before, after in pairwise(states)]
    return {"normal": normal, "largest": largest, "net": net, "velocity": states[-1].v, "variation": sum(changes)}


def summary(tables: Tables) -> Summary:
    rows = tables["refinement"].sort_values("step", ascending=False)
    groups = dict(tuple(rows.groupby(["scene", "solver"])))
    restless = [" by ".join(key) for key, one in groups.items() if not (_settles(one["net"]) and _settles(one["velocity"]))]
    finest = rows[rows["step"] == rows["step"].min()]
    spread = finest.groupby("scene").agg(
        normal=("normal", np.ptp), middle=("normal", "median"), net=("net", widest), velocity=("velocity", widest)
    )
    parted = spread[spread["velocity"] > ANOTHER_ANSWER]
    loose = spread[(spread["velocity"] <= ANOTHER_ANSWER) & (spread["normal"] > ANOTHER_ANSWER * spread["middle"])]
    rod = finest[(finest["scene"] == "rod")]["largest"]
    numbers = {
        "steady": len(groups) - len(restless),
        "pairs": len(groups),
        "growth": f"{max(one['variation'].iloc[-1] / one['variation'].iloc[0] for one in groups.values()):.2f}",
        "parted_names": listing([*parted.index]),
        "small": f"{100 * SETTLED_CHANGE:.0f}",
        "restless": listing(restless),
        "rod": [f"{rod.min():.4f}", f"{rod.max():.4f}"],
        "rod_limit": f"{ROD:g}",
        "parted_each": {name: f"{row['velocity']:.2g}" for name, row in parted.iterrows()},
        "loose_each": {
            name: (f"{100 * row['normal'] / row['middle']:.0f}", f"{row['net']:.0e}") for name, row in loose.iterrows()
        },
    }
    figures = {
        "refinement": (
            Panel("normal impulses", partial(_draw, rows=rows, column="normal")),
            Panel("variation of the velocity", partial(_draw, rows=rows, column="variation")),
        ),
    }
    return Summary(numbers, figures)


def _settles(values: pd.Series) -> bool:
    vectors = np.array([np.atleast_1d(value) for value in values], dtype=float)
    return bool(np.linalg.norm(vectors[-1] - vectors[-2]) <= max(SETTLED_CHANGE * np.abs(vectors).max(), CHANGE_ROUNDING))


def _draw(ax: Axes, rows: pd.DataFrame, column: str) -> None:
    for k, (scene, group) in enumerate(rows.groupby("scene")):
        lemke = group[group["solver"] == "lemke"][column]
        unit = (lemke.iloc[-1] if column == "normal" else lemke.iloc[0]) or 1.0
        ax.plot([], [], color=COLOURS[k], label=str(scene))
        for j, (solver, own) in enumerate(group.groupby("solver")):
            look: dict[str, Any] = {
                "mfc": "none",
                "mew": 0.7,
                "ms": 2.5 + 1.5 * j,
                "lw": 0.8,
            }  # shows all of several that coincide
            curve(ax, j, own["step"], own[column] / unit, color=COLOURS[k], **look)
            curve(ax, j, [], [], str(solver) if scene == rows["scene"].max() else "", color=INK, **look)
    finish(ax, "step, s", "relative", "x")


STUDY = Study((refinement,), summary)
