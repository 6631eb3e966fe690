"""Compliant or rigid? Errors and work against stiffness, and what springs say where the rigid model says two things."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from frictionbench.harness.studies.motions import FINEST, SAMPLES, by_events, sampled
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems.compliant import comply
from frictionbench.problems.scenes import scene
from frictionbench.problems.schemes.impact import impact
from frictionbench.results.store import Row

CASES: dict[str, tuple[dict[str, Any], float]] = {
    "bouncing_ball": ({"restitution": 0.5, "height": 0.2}, 0.5),
    "stopping_block": ({"speed": 0.5}, 0.2),
    "painleve_rod": ({"friction": 0.5}, 0.9),
    "rocking_block": ({"tilt": 0.05}, 0.4),
}
SLIP = 1e-4  # m/s, at the stiffness 1e4 N/m; it falls as the indentation does


def stiffnesses(
    names: Iterable[str] = tuple(CASES),
    values: Iterable[float] = (1e4, 1e5, 1e6, 1e7),
    methods: Iterable[str] = ("Radau", "BDF"),
) -> Iterator[Row]:
    """Compliant motions compared at ten times with the rigid one by events."""
    for name in names:
        settings, duration = CASES[name]
        made = scene(name, **settings, step=duration / SAMPLES, duration=duration)
        sampled(made, by_events(impact, 1e-3))  # compiles what it calls
        begun = perf_counter()
        known, work = sampled(made, by_events(impact, FINEST))
        rigid = perf_counter() - begun
        for stiffness in values:
            for method in methods:
                begun = perf_counter()
                found = comply(made, stiffness, SLIP * 1e4 / stiffness, 1e-7, method=method)
                time = perf_counter() - begun
                error = float(np.abs(found.q[1:] - known).max())
                yield {
                    "scene": name,
                    "stiffness": stiffness,
                    "method": method,
                    "error": error,
                    "work": found.evaluations,
                    "rigid_work": work,
                    "time": time,
                    "rigid_time": rigid,
                }


def indentations(shares: Iterable[float] = (0.0, 0.5, 0.9, 1.1, 1.5, 3.0), stiffness: float = 1e8) -> Iterator[Row]:
    """Painlevé's rod with p < 0 < K, where open and closed are solutions; it starts with a share of the closed one's force."""
    made = scene("painleve_rod", spin=4.0, tip_velocity=-3.0, duration=0.002, step=0.002)
    p, K = _index(float(made.q0[2]), 1.5), 16 * np.sin(made.q0[2]) - 9.81
    for share in shares:
        found = comply(replace(made, q0=made.q0 - [0, share * -K / p / stiffness, 0]), stiffness, 1e-6)
        yield {"share": share, **_tip(found.q[-1], found.v[-1]), "spin": float(found.v[-1, 2])}


def inconsistent(values: Iterable[float] = (1e4, 1e6, 1e8), speed: float = -1.0) -> Iterator[Row]:
    """Painlevé's rod where no force is a solution: the impulse of the springs up to the end of their contact."""
    made = scene("painleve_rod", tip_velocity=speed)
    angle, weight = float(made.q0[2]), float(made.weights[0])
    least = weight * 0.75 * np.sin(angle) * np.cos(angle) * -speed
    for stiffness in values:
        duration = 30 / np.sqrt(stiffness)
        stage = replace(made, step=duration, duration=duration)
        times = np.linspace(0, duration, 400)
        found = comply(stage, stiffness, 1e-6, times=times)
        impulse = weight * (found.v[:, 1] + 9.81 * times)  # vertical, of the contact alone
        slip = found.v[:, 0] + found.v[:, 2] * np.sin(found.q[:, 2])
        closing = found.v[:, 1] - found.v[:, 2] * np.cos(found.q[:, 2])
        fastest = int(closing.argmin())
        after = fastest + int(np.argmax(closing[fastest:] >= 0))  # the springs are pressed most just before
        share = closing[after] / (closing[after] - closing[after - 1])
        yield {
            "stiffness": stiffness,
            "stopped": float(times[after] - share * (times[after] - times[after - 1])),
            "impulse": float(impulse[after] - share * (impulse[after] - impulse[after - 1])),
            "slip": float(slip[after]),
            "total": float(impulse[-1]),
            "rigid": float(least),
            "indentation": float(-(found.q[:, 1] - np.sin(found.q[:, 2])).min()),
        }


def _index(angle: float, friction: float) -> float:
    """p of the rod of 1 kg and half length 1 m that slides to the left."""
    return 1 + 3 * np.cos(angle) ** 2 - 3 * friction * abs(np.sin(angle) * np.cos(angle))


def _tip(q: np.ndarray, v: np.ndarray) -> Row:
    """The velocity of the rod's tip."""
    return {"slip": float(v[0] + v[2] * np.sin(q[2])), "lift": float(v[1] - v[2] * np.cos(q[2]))}


STUDY = Study(
    name="compliance",
    question="Compliant or rigid?",
    method="""Scenes with a spring and a damper at each contact and friction regularised by tanh, whose speed falls as the
    stiffness grows, are integrated by scipy's Radau and BDF and compared at ten times with the rigid motion by events.
    Painlevé's rod is started where two forces are solutions, open and closed, with springs pressed to a share of the closed
    solution's force; and where no force is, at growing stiffness, beside the rigid impulse that stops its tip.""",
    tables=(
        Table(
            stiffnesses,
            {
                "scene": "scene",
                "stiffness": "k, N/m",
                "method": "scipy's integrator",
                "error": "the largest distance of a coordinate from the rigid motion, m or rad",
                "work": "evaluations of the forces",
                "rigid_work": "friction problems and evaluations of forces of the rigid motion",
                "time": "s, of the compliant motion",
                "rigid_time": "s, of the rigid motion",
            },
        ),
        Table(
            indentations,
            {
                "share": "the spring's force at the start over that of the closed solution",
                "slip": "the tip's tangential velocity after 2 ms, m/s; -3 at the start",
                "lift": "its normal velocity after 2 ms, m/s",
                "spin": "rad/s; 4 at the start",
            },
        ),
        Table(
            inconsistent,
            {
                "stiffness": "k, N/m",
                "stopped": "when the springs were pressed most and the tip had stopped, s",
                "impulse": "normal impulse until then, N s",
                "slip": "the tip's tangential velocity then, m/s",
                "total": "normal impulse until the springs were free, N s",
                "rigid": "the rigid impulse that stops the tip, N s",
                "indentation": "the deepest, m",
            },
        ),
    ),
)
