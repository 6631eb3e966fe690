"""Painlevé's paradox and discontinuity in initial data: how far motions with nearly equal initial data diverge."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from math import hypot, sqrt
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, NoSolution, Scene, simulation
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from studies.motions import by
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, listing, require

PARTED = 1e3  # ratio to the first distance that smooth growth in so short a motion does not explain
JAM, RODS = "jam", ("rod at p > 0", "rod at p < 0")
EDGE = "rod leaving at p < 0"
EVENTS = "event_driven"
STEP, STEPS = 0.002, 10  # step, s; number of steps
G, HEIGHT, FALL, ASPECT = 9.81, 0.0051, 1.0, 3.0  # m/s^2; a tall block's height of fall, m; initial speed, m/s; aspect ratio
ROD = {"tip_velocity": -3.0, "friction": 1.6}  # at its steepest angle, where p < 0 from mu = 4/3 on
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "rod at p > 0": ("painleve_rod", ROD | {"friction": 1.0}),
    "rod at p < 0": ("painleve_rod", ROD),
    "rod leaving at p < 0": ("painleve_rod", ROD | {"lift": G * STEP}),
    "jam": ("jam", {"sideways": 0.1}),  # moves towards a wall: otherwise zero impulses would be a solution
    "flat landing": ("two_corner_block", {"fall": FALL, "friction": 1.0, "aspect": ASPECT, "velocity": 0.0}),
}
SCHEMES_COMPARED = ("anitescu_potra", "stewart_trinkle", "moreau", "event_driven")
SOLVERS = ("lemke", "nsgs", "interior_point")
SIZES = (1e-8, 1e-5, 1e-2)  # of the changes, m/s
SPINS = tuple(float(10.0**power) for power in np.arange(-6, -0.5, 0.5))  # rad/s: the second hit falls within the motion


def ensembles(
    cases: Iterable[str] = CASES,
    schemes: Iterable[str] = SCHEMES_COMPARED,
    solvers: Iterable[str] = SOLVERS,
    sizes: Iterable[float] = SIZES,
    members: int = 4,
) -> Iterator[Row]:
    """Neighbours of each undisturbed motion: the largest distances of any of them, of velocities in m/s and rad/s.

    They are those up to the first step without a solution; at the end, those of motions that reach it.
    """
    for case, scheme, solver in product(cases, schemes, solvers):
        stage = begin(case)
        middle = motion(stage, scheme, solver)
        for size in sizes:
            away, short = np.zeros((members, 2, STEPS)), 0
            for seed in range(members):
                way = np.random.default_rng(seed).normal(size=len(stage.v0))
                found = motion(replace(stage, v0=stage.v0 + size * way / np.linalg.norm(way)), scheme, solver)
                common = min(len(found), len(middle))
                short += len(found) != len(middle)
                away[seed, :, :common] = np.linalg.norm(found[:common] - middle[:common], axis=2).T
            yield {
                "case": case,  # of motion
                "scheme": scheme,  # time-stepping scheme
                "solver": solver,  # of the steps, to 1e-10
                "size": size,  # of the change of the first velocities, m/s and rad/s
                "steps": len(middle),  # of the undisturbed motion, STEPS unless one has no solution
                "short": short,  # neighbours with another number of steps
                "velocities": middle[:, 1].ravel(),  # of the undisturbed motion after each step
                "moved": away[:, 0].max(),  # distance of positions on the way, m and rad
                "most_apart": away[:, 1].max(),  # distance of velocities on the way
                "apart": away[:, 1, -1].max() if len(middle) == STEPS else None,  # distance of velocities at the end
            }


def begin(case: str) -> Scene:
    """Return the undisturbed initial state; the landing block is raised to its height of fall."""
    name, settings = CASES[case]
    stage = fb.scene(name, **settings, step=STEP)
    return replace(stage, q0=stage.q0 + np.array([0.0, HEIGHT, 0.0])) if case == "flat landing" else stage


def motion(stage: Scene, scheme: str, solver: str) -> Array:
    """The positions and velocities (steps, 2, nv) after each step, fewer where the scheme has no solution."""
    found = []
    try:
        for now in simulation(stage, by(solver), SCHEMES[scheme], STEPS):
            found.append((now.q, now.v))  # noqa: PERF401, what was found before the failure is kept
    except NoSolution:
        pass
    return np.array(found[1:]).reshape(-1, 2, len(stage.v0))


def landings(schemes: Iterable[str] = SCHEMES_COMPARED, spins: Iterable[float] = SPINS) -> Iterator[Row]:
    """A tall block that lands almost flat with a small spin: one corner hits first, the other a moment later.

    closed: the final spin after two impacts in sequence, with half width b, half height H and R^2 = b^2 + H^2. The first impact
    makes the block rotate about its corner at v b/(4/3 R^2), less a quarter of the small spin, until the other corner hits; the
    second leaves 1 - 3/2 (b/R)^2 of that (Housner 1963). Gravity adds 3/4 g b/R^2 per second before, and takes as much after.
    """
    speed, b, radius = sqrt(FALL**2 + 2 * G * HEIGHT), 0.5, hypot(0.5, ASPECT / 2)
    falling = STEPS * STEP - (speed - FALL) / G
    first, gain = speed * b / (4 / 3 * radius**2), 0.75 * G * b / radius**2  # rad/s after the first hit, and rad/s^2
    closed = first * (1 - 1.5 * (b / radius) ** 2) - gain * falling
    for scheme, spin in product(schemes, spins):
        stage = begin("flat landing")
        found = motion(replace(stage, v0=stage.v0 + np.array([0.0, 0.0, spin])), scheme, "lemke")
        tilt, start = spin * (speed - FALL) / G, first - spin / 4
        yield {
            "scheme": scheme,  # time-stepping scheme
            "spin": spin,  # of the start, rad/s
            "delay": 2 * tilt / (start + sqrt(start**2 + 2 * gain * tilt)),  # between the two hits, s
            "after": abs(float(found[-1, 1, 2])) if len(found) == STEPS else None,  # spin at the end, rad/s
            "closed": closed,  # the same by the closed form of two hits in sequence, rad/s
        }


def summary(tables: Tables) -> Summary:
    rows, landings = tables["ensembles"], tables["landings"]
    grown = {"way": rows["most_apart"], "places": rows["moved"] / (STEPS * STEP), "end": rows["apart"]}
    rows = rows.assign(**{name: distance / rows["size"] for name, distance in grown.items()})
    parted = {name: rows[rows[name] > PARTED] for name in grown}
    whole = rows[rows["steps"] == STEPS]
    most, silent = whole.groupby(["case", "scheme", "solver"])[[*grown]].max(), rows[rows["steps"] < STEPS]
    verdicts = most > PARTED
    inside = whole[whole["case"].isin(RODS)].groupby("size")[[*grown]].max()
    require((inside < PARTED).all(axis=None), "neighbours of the rod on the ground stay neighbours")
    jam = whole[whole["case"] == JAM].drop_duplicates(["scheme", "solver"])
    paths = np.stack(list(jam["velocities"])).reshape(jam["scheme"].nunique(), -1, STEPS, 3)  # by scheme and solver
    between = np.linalg.norm(paths[:, :, None] - paths[:, None], axis=-1).max(axis=(0, 1, 2))  # the solvers of one scheme
    events = landings[landings["scheme"] == EVENTS].sort_values("spin")
    others = landings[landings["scheme"] != EVENTS]
    lost = (others["after"] < 0.1 * others["closed"]).groupby(others["scheme"]).cummin()  # up to the first that is kept
    small = others[lost].groupby("scheme")["delay"].max()
    error = abs(events["after"].iloc[0] / events["closed"].iloc[0] - 1)
    require(error < 0.01, "the event-driven spin is that of the closed form")
    numbers = {name: _told(part) for name, part in parted.items()} | {
        "parted_limit": f"{PARTED:g}",
        "agree": f"{verdicts.eq(verdicts['way'], axis=0).all(axis=1).sum()} of {len(verdicts)}",
        "alike": verdicts.groupby(["case", "scheme"]).nunique().eq(1).all(axis=1).all(),
        "jam": [between.max(), between[0], between[-1]],
        "gap": [most[~verdicts].max(axis=None), most[verdicts].min(axis=None)],
        "inside": inside.reset_index().to_dict("records"),
        "edge": parted["way"].loc[parted["way"]["case"] == EDGE, ["most_apart", "moved", "apart"]].max(),
        "first": events.iloc[0].to_dict(),
        "late": listing([f"{name} up to {delay:.1g} s" for name, delay in small.items()]),
        "longest": f"{others['delay'].max():.1g}",
        "without": listing([f"{case} by {scheme}" for case, scheme in silent.groupby(["case", "scheme"]).groups]),
        "short": [silent["short"].sum(), whole["short"].sum()],
    }
    figures = {"edges": (Panel("order of two hits", partial(_landings, landings=landings)),)}
    return Summary(numbers, figures)


def _told(part: pd.DataFrame) -> str:
    """Return the cases, each with its schemes and their smallest change."""
    least = part.groupby(["case", "scheme"])["size"].min().reset_index()
    least["told"] = least["scheme"] + least["size"].map(" from {:.0e}".format)
    return "; ".join(f"{case} ({', '.join(group['told'])})" for case, group in least.groupby("case")) or "none"


def _landings(ax: Axes, landings: pd.DataFrame) -> None:
    for k, (scheme, group) in enumerate(landings.groupby("scheme")):
        curve(ax, k, group["delay"], group["after"], str(scheme))
    ax.axhline(landings["closed"].iloc[0], color=INK, lw=0.6, ls=":")
    finish(ax, "delay between the hits, s", "spin, rad/s", "x")


STUDY = Study((ensembles, landings), summary)
