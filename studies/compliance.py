"""Compliant or rigid? Errors and work against stiffness, and the results of springs where the rigid model has two solutions."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import impact
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM
from studies.motions import REFERENCE_ACCURACY, SAMPLES, by_events, sampled
from studies.springs import comply
from studies.study import Row, Study, Summary, Tables, finish, listing, order, require

CASES: dict[str, tuple[dict[str, Any], float]] = {
    "bouncing_ball": ({"restitution": 0.5, "height": 0.2}, 0.5),
    "stopping_block": ({"speed": 0.5}, 0.2),
    "painleve_rod": ({"friction": 0.5}, 0.9),
    "rocking_block": ({"tilt": 0.05}, 0.4),
}
ACCURACY = 1e-7  # relative, of both motions whose evaluations are compared
SAME = 1.25  # ratio of two integrators' distances up to which they agree
SLIP = 1e-4  # m/s, at the stiffness 1e4 N/m; it decreases like the indentation


def stiffnesses(
    names: Iterable[str] = tuple(CASES),
    values: Iterable[float] = (1e4, 1e5, 1e6, 1e7),
    methods: Iterable[str] = ("Radau", "BDF"),
) -> Iterator[Row]:
    """Compare compliant motions at ten times with the rigid motion by the event-driven scheme."""
    for name in names:
        settings, duration = CASES[name]
        made = fb.scene(name, **settings, step=duration / SAMPLES, duration=duration)
        known, _ = sampled(made, by_events(impact, REFERENCE_ACCURACY))
        rigid, work = sampled(made, by_events(impact, ACCURACY))
        for stiffness in values:
            for method in methods:
                found = comply(made, stiffness, SLIP * 1e4 / stiffness, ACCURACY, method=method)
                error = float(np.abs(found.q[1:] - known).max())
                yield {
                    "scene": name,
                    "stiffness": stiffness,  # k, N/m
                    "method": method,  # scipy's integrator
                    "error": error,  # the largest distance of a coordinate from the rigid motion, m or rad
                    "work": found.evaluations,  # evaluations of the forces
                    "rigid_work": work,  # friction problems and evaluations of forces of the rigid motion by events
                    "rigid_error": float(np.abs(rigid - known).max()),  # of that motion, as above
                }


def indentations(shares: Iterable[float] = (0.0, 0.5, 0.9, 1.1, 1.5, 3.0), stiffness: float = 1e8) -> Iterator[Row]:
    """Painlevé's rod with p < 0 < K, where an open and a closed contact are solutions; it starts with part of the closed force.

    share: the spring's force at the start over that of the closed solution; spin: after 2 ms, rad/s; 4 at the start.
    """
    made = fb.scene("painleve_rod", spin=4.0, tip_velocity=-3.0, duration=0.002, step=0.002)
    cos, sin = np.cos(made.q0[2]), np.sin(made.q0[2])
    p, K = 1 + 3 * cos**2 - 4.5 * sin * cos, 16 * sin - 9.81  # of 1 kg and half length 1 m, with mu = 1.5, sliding to the left
    for share in shares:
        found = comply(replace(made, q0=made.q0 - [0, share * -K / p / stiffness, 0]), stiffness, 1e-6)
        yield {"share": share, "spin": float(found.v[-1, 2])}


def inconsistent(values: Iterable[float] = (1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12), speed: float = -1.0) -> Iterator[Row]:
    """Painlevé's rod without a solution in forces: the impulse of the springs up to the end of their contact."""
    made = fb.scene("painleve_rod", tip_velocity=speed)
    angle, weight = float(made.q0[2]), float(made.weights[0])
    least = weight * 0.75 * np.sin(angle) * np.cos(angle) * -speed
    for stiffness in values:
        duration = 30 / np.sqrt(stiffness)
        stage = replace(made, step=duration, duration=duration)
        times = np.linspace(0, duration, 400)
        found = comply(stage, stiffness, 1e-6, times=times)
        impulse = weight * (found.v[:, 1] + 9.81 * times)  # vertical, of the contact alone
        closing = found.v[:, 1] - found.v[:, 2] * np.cos(found.q[:, 2])
        fastest = int(closing.argmin())
        after = fastest + int(np.argmax(closing[fastest:] >= 0))  # the largest compression is just before
        share = closing[after] / (closing[after] - closing[after - 1])
        yield {
            "stiffness": stiffness,  # k, N/m
            # when the springs were pressed most and the tip had stopped, s
            "stopped": float(times[after] - share * (times[after] - times[after - 1])),
            "impulse": float(impulse[after] - share * (impulse[after] - impulse[after - 1])),  # normal impulse until then, N s
            "total": float(impulse[-1]),  # normal impulse until the springs were free, N s
            "rigid": float(least),  # the rigid impulse that stops the tip, N s
        }


def summary(tables: Tables) -> Summary:
    table, pressed, stuck = (tables[name] for name in ("stiffnesses", "indentations", "inconsistent"))
    least = table.groupby(["scene", "stiffness"])["error"].transform("min")
    table = table.assign(
        scene=table["scene"].str.replace("_", " "), ratio=table["work"] / table["rigid_work"], off=table["error"] / least
    )
    good = table[table["off"] < SAME]
    cheapest = good.loc[good.groupby(["scene", "stiffness"])["ratio"].idxmin()]
    stiffest = table[table["stiffness"] == table["stiffness"].max()]
    less, more = pressed[pressed["share"] < 1], pressed[pressed["share"] > 1]
    require(((less["spin"] - 4).abs() < 0.5).all(), "springs pressed less than the closed solution's let the rod lift")
    require(((more["spin"] - 4).abs() > 0.5).all(), "springs pressed more than that throw the rod")
    require((stuck["impulse"] > 0).all(), "the springs stop the tip")
    off = order(1 / stuck["stiffness"], (stuck["impulse"] / stuck["rigid"] - 1).abs())
    require(off.small > off.large, "the order of the springs' impulse rises with the stiffness")
    numbers = {
        "range": [f"{k:.0e}" for k in table["stiffness"].agg(["min", "max"])],
        "cheapest": _range(cheapest.merge(stiffest)),
        "methods": " and ".join(f"{_range(part)} with {name}" for name, part in stiffest.groupby("method")),
        "distances": ", ".join(
            f"{name} {part['error'].min():.0e}, order {order(1 / part['stiffness'], part['error'])}"
            for name, part in cheapest.groupby("scene")
        ),
        "bad": [row._asdict() for row in table.drop(good.index).itertuples()],
        "same": SAME,
        "events": f"{table['rigid_error'].max():.0e}",
        "less": listing([f"{x:g}" for x in less["share"]]),
        "more": listing([f"{x:g}" for x in more["share"]]),
        "stuck": stuck.assign(off=100 * (stuck["impulse"] / stuck["rigid"] - 1).abs()).to_dict("records"),
        "off": off,
    }
    figures = {
        "stiffness": [Panel(column, partial(_lines, table=table, column=column)) for column in ("error", "work")],
        "painleve": (Panel("the springs decide", partial(_decided, pressed=pressed)),),
    }
    return Summary(numbers, figures)


def _range(part: pd.DataFrame) -> str:
    return f"{part['ratio'].min():.2g} to {part['ratio'].max():.3g}"


def _lines(ax: Axes, table: pd.DataFrame, column: str) -> None:
    for (name, method), rows in table.groupby(["scene", "method"]):
        look: dict[str, Any] = {"marker": "o", "ls": "-"} if method == "Radau" else {"marker": "x", "ls": ":"}
        number = list(dict.fromkeys(table["scene"])).index(name)
        ax.plot(rows["stiffness"], rows[column], color=f"C{number}", ms=4, label=name if method == "Radau" else None, **look)
    finish(ax, "stiffness, N/m", "distance, m or rad" if column == "error" else "evaluations", "xy")


def _decided(ax: Axes, pressed: pd.DataFrame) -> None:
    ax.plot(pressed["share"], pressed["spin"], "o-", color="#0077bb")
    ax.axvline(1.0, color=ALARM, ls="--", lw=0.8)
    finish(ax, "force at the start over the closed solution's", "spin after 2 ms, rad/s")


STUDY = Study((stiffnesses, indentations, inconsistent), summary)
