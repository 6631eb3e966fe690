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
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, listing, require, widest

PARTED = 20.0  # ratio of final to initial distance that smooth growth in so short a motion does not explain
SAME_VELOCITY = 1e-6  # m/s: answers of two solvers that differ by less are equal
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
    """Neighbours of each undisturbed motion: the largest distance of velocities during the motion, and at the end."""
    for case, scheme, solver in product(cases, schemes, solvers):
        stage = begin(case)
        middle = motion(stage, scheme, solver)
        for size in sizes:
            apart, last = [], []
            for seed in range(members):
                way = np.random.default_rng(seed).normal(size=len(stage.v0))
                found = motion(replace(stage, v0=stage.v0 + size * way / np.linalg.norm(way)), scheme, solver)
                common = min(len(found), len(middle))
                away = np.linalg.norm(found[:common] - middle[:common], axis=1)
                apart.append(float(away.max(initial=0.0)))
                last.append(float(away[-1]) if common == STEPS else None)
            whole = len(middle) == STEPS
            yield {
                "case": case,  # of motion
                "scheme": scheme,  # time-stepping scheme
                "solver": solver,  # of the steps, to 1e-10
                "size": size,  # of the change of the first velocities, m/s and rad/s
                # at the end of the undisturbed motion, null where a step has no solution; m/s and rad/s
                "velocity": middle[-1] if whole else None,
                # largest distance of a neighbour's velocities on the way, m/s and rad/s
                "most_apart": max(apart) if whole else None,
                "apart": max((end for end in last if end is not None), default=None),  # the same at the end
            }


def begin(case: str) -> Scene:
    """Return the undisturbed initial state; the landing block is raised to its height of fall."""
    name, settings = CASES[case]
    stage = fb.scene(name, **settings, step=STEP)
    return replace(stage, q0=stage.q0 + np.array([0.0, HEIGHT, 0.0])) if case == "flat landing" else stage


def motion(stage: Scene, scheme: str, solver: str, steps: int = STEPS) -> Array:
    """The velocities (steps, nv) after each step, fewer where the scheme has no solution."""
    found = []
    try:
        for now in simulation(stage, by(solver), SCHEMES[scheme], steps):
            found.append(now.v)  # noqa: PERF401, what was found before the failure is kept
    except NoSolution:
        pass
    return np.array(found[-steps:]).reshape(-1, len(stage.v0))


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
            "after": abs(float(found[-1, 2])) if len(found) == STEPS else None,  # spin at the end, rad/s
            "closed": closed,  # the same by the closed form of two hits in sequence, rad/s
        }


def summary(tables: Tables) -> Summary:
    rows, landings = tables["ensembles"], tables["landings"]
    rows = rows.assign(parted=rows["apart"] > PARTED * rows["size"], none=rows["velocity"].isna())
    pairs = rows.groupby(["case", "scheme", "solver"])[["parted", "none"]].any().reset_index()
    inside = rows[rows["case"].isin(RODS) & ~rows["none"]]
    require(not inside["parted"].any(), "neighbours of the rod on the ground stay neighbours")
    parted = pairs[pairs["parted"]]
    silent = pairs[pairs["none"]]
    jam = rows[(rows["case"] == JAM) & ~rows["none"]].drop_duplicates(["scheme", "solver"])
    between = jam.groupby("scheme")["velocity"].agg(widest).max()  # between solvers with one scheme
    edge = rows[(rows["case"] == EDGE) & rows["parted"]]
    events = landings[landings["scheme"] == EVENTS].sort_values("spin")
    others = landings[landings["scheme"] != EVENTS]
    small = others[others["after"] < 0.1 * others["closed"]].groupby("scheme")["delay"].max()
    error = abs(events["after"].iloc[0] / events["closed"].iloc[0] - 1)
    require(error < 0.01, "the event-driven spin is that of the closed form")
    numbers = {
        "parted": listing(sorted(parted["case"].unique())),
        "jam": f"differ by up to {between:.2g} m/s" if between > SAME_VELOCITY else "are the same",
        "gain": f"{(inside['apart'] / inside['size']).max():.2g}",
        "parted_limit": f"{PARTED:g}",
        "cases": "; ".join(f"{case} ({_pairs(group)})" for case, group in parted.groupby("case")),
        "edge_most": f"{edge['most_apart'].max():.2g}",
        "edge": f"{edge['apart'].max():.1g}",
        "spin": f"{events['spin'].iloc[0]:.0e}",
        "delay": f"{events['delay'].iloc[0]:.1g}",
        "after": f"{events['after'].iloc[0]:.3f}",
        "closed": f"{events['closed'].iloc[0]:.3f}",
        "late": listing([f"{name} up to {delay:.1g} s" for name, delay in small.items()]),
        "longest": f"{others['delay'].max():.1g}",
        "without": [f"{case} ({_pairs(group)})" for case, group in silent.groupby("case")],
    }
    figures = {"edges": (Panel("order of two hits", partial(_landings, landings=landings)),)}
    return Summary(numbers, figures)


def _pairs(group: pd.DataFrame) -> str:
    """Return the schemes, each with its solvers."""
    return ", ".join(f"{scheme} with {listing(list(part['solver']))}" for scheme, part in group.groupby("scheme"))


def _landings(ax: Axes, landings: pd.DataFrame) -> None:
    for k, (scheme, group) in enumerate(landings.groupby("scheme")):
        curve(ax, k, group["delay"], group["after"], str(scheme))
    ax.axhline(landings["closed"].iloc[0], color=INK, lw=0.6, ls=":")
    finish(ax, "delay between the hits, s", "spin, rad/s", "x")


STUDY = Study((ensembles, landings), summary)
