"""Are higher-order methods relevant? Orders of convergence of the schemes, and drift at contacts and joints."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from frictionbench.harness.studies.moves import coulomb
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems.check import Array
from frictionbench.problems.scenes import scene
from frictionbench.problems.schemes import SCHEMES, NoSolution
from frictionbench.problems.simulate import simulate
from frictionbench.results.store import Row

SCHEMES_COMPARED = ("anitescu_potra", "stewart_trinkle", "moreau", "moreau_euler", "lotstedt", "acceleration")
MOTIONS: dict[str, tuple[str, dict[str, Any], float]] = {
    # kind: scene, settings and duration; no event falls on a step of all grids
    "pendulum": ("pendulum", {}, 0.4),
    "smooth sliding": ("bowl", {"friction": 0.1}, 0.4),
    "stick-slip": ("bowl", {"friction": 0.3}, 1.2),
    "impacts": ("bouncing_ball", {"height": 0.3}, 0.8),
}
STEPS = (0.02, 0.01, 0.005, 0.0025)
FINER = 4  # the reference's step is so many times smaller than the finest


def errors(
    schemes: Iterable[str] = SCHEMES_COMPARED, steps: Iterable[float] = STEPS, kinds: Iterable[str] = MOTIONS
) -> Iterator[Row]:
    """The position at the end of each motion beside one with a much smaller step of the same scheme, and the worst drift."""
    steps = tuple(steps)
    for kind in kinds:
        name, settings, duration = MOTIONS[kind]
        first: Array | None = None
        for scheme in schemes:
            if SCHEMES[scheme].refuses(scene(name, **settings)):
                continue
            try:
                exact, _ = end(name, settings, duration, min(steps) / FINER, scheme)
                found = [(step, *end(name, settings, duration, step, scheme)) for step in steps]
            except NoSolution:
                continue
            first = exact if first is None else first
            for step, q, drift in found:
                yield {
                    "kind": kind,
                    "scheme": scheme,
                    "step": step,
                    "error": float(np.linalg.norm(q - exact)),
                    "drift": drift,
                    "limits_apart": float(np.linalg.norm(exact - first)),
                }


def end(name: str, settings: dict[str, Any], duration: float, step: float, scheme: str) -> tuple[Array, float]:
    """The last position (nv,), and the largest penetration or violation of a joint on the way, m."""
    stage, drift = scene(name, **settings, step=step), 0.0
    for now in simulate(stage, coulomb, SCHEMES[scheme], round(duration / step)):
        joints = np.abs(stage.joints(now.q)[0]).max(initial=0.0)
        drift = max(drift, stage.deepest_overlap(now.q), float(joints))
    return now.q, drift


STUDY = Study(
    name="orders",
    question="Are higher-order methods relevant?",
    method=f"""A pendulum, smooth sliding, stick and slip, and impacts are computed by every scheme that treats them,
    with steps from {STEPS[0]:g} to {STEPS[-1]:g} s. The error is the distance of the position at the end from one
    with a step {FINER} times smaller than the finest; the order is the slope of its logarithm by least squares. The limits of
    different schemes are compared, so that none converges to something else. Drift is the largest penetration, or violation of
    a joint, on the way. Every step is solved to 1e-10.""",
    tables=(
        Table(
            errors,
            {
                "kind": "of motion",
                "scheme": "time-stepping scheme",
                "step": "s",
                "error": "of the position at the end, m",
                "drift": "largest penetration or violation of a joint on the way, m",
                "limits_apart": "distance of the scheme's finest position from that of the first scheme, m",
            },
        ),
    ),
)
