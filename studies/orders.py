"""Are higher-order methods relevant? Orders of convergence of the schemes, and drift at contacts and joints."""

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, NoSolution, simulation
from frictionbench.reports import Panel
from studies.motions import coulomb
from studies.study import Array, Row, Slope, Study, Summary, Tables, curve, finish, listing, order

ROUNDING = 1e-10  # m: errors and drifts below it have no order
BEYOND = 1.3  # an order whose interval lies above it is not the first
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
            if SCHEMES[scheme].refuses(fb.scene(name, **settings)):
                continue
            try:
                exact, _ = end(name, settings, duration, min(steps) / FINER, scheme)
                found = [(step, *end(name, settings, duration, step, scheme)) for step in steps]
            except NoSolution:
                continue
            first = exact if first is None else first
            for step, q, drift in found:
                yield {
                    "kind": kind,  # of motion
                    "scheme": scheme,  # time-stepping scheme
                    "step": step,  # s
                    "error": float(np.linalg.norm(q - exact)),  # of the position at the end, m
                    "drift": drift,  # largest penetration or violation of a joint on the way, m
                    # distance of the scheme's finest position from that of the first scheme, m
                    "limits_apart": float(np.linalg.norm(exact - first)),
                }


def end(name: str, settings: dict[str, Any], duration: float, step: float, scheme: str) -> tuple[Array, float]:
    """The last position (nv,), and the largest penetration or violation of a joint on the way, m."""
    stage, drift = fb.scene(name, **settings, step=step), 0.0
    for now in simulation(stage, coulomb, SCHEMES[scheme], round(duration / step)):
        joints = np.abs(stage.joints(now.q)[0]).max(initial=0.0)
        drift = max(drift, stage.deepest_overlap(now.q), float(joints))
    return now.q, drift


def summary(found: Tables) -> Summary:
    errors = found["errors"]
    slopes = {key: order(own["step"], own["error"]) for key, own in errors.groupby(["kind", "scheme"]) if _moves(own["error"])}
    drifts = {key: order(own["step"], own["drift"]) for key, own in errors.groupby(["kind", "scheme"]) if _moves(own["drift"])}
    kinds = list(dict.fromkeys(errors["kind"]))
    high = {kind: [s for (k, s), slope in slopes.items() if k == kind and slope.value - slope.half > BEYOND] for kind in kinds}
    gains = [kind for kind in kinds if high[kind]]
    nearest = max(slopes, key=lambda key: slopes[key].value - slopes[key].half)
    lost = [kind for kind in kinds if not high[kind]]
    apart = errors.groupby(["kind", "scheme"]).agg(apart=("limits_apart", "first"), error=("error", "min"))
    differing = apart[apart["apart"] > 10 * apart["error"].clip(lower=1e-4)]
    numbers = {
        "gains_and_losses": gains and lost,
        "gains": listing(gains),
        "lost": listing(lost),
        "no_gains": not gains,
        "beyond": f"{BEYOND:g}",
        "nearest_scheme": nearest[1],
        "nearest_kind": nearest[0],
        "nearest_order": slopes[nearest],
        "by_kind": "; ".join(
            f"{kind}: " + ", ".join(f"{s} {slopes[kind, s]}" for k, s in slopes if k == kind) for kind in kinds
        ),
        "drift": "; ".join(_drift(kind, drifts, errors) for kind in ("pendulum", "smooth sliding") if kind in kinds),
        "same_limit": differing.empty,
        "others": listing([f"{s} in {kind} ({row['apart']:.1g} m apart)" for (kind, s), row in differing.iterrows()]),
    }
    figures = {
        "orders": tuple(Panel(kind, partial(_draw, own=errors[errors["kind"] == kind], column="error")) for kind in kinds),
        "drift": tuple(
            Panel(f"drift, {kind}", partial(_draw, own=errors[errors["kind"] == kind], column="drift"))
            for kind in ("pendulum", "smooth sliding")
            if kind in kinds
        ),
    }
    return Summary(numbers, figures)


def _moves(values: pd.Series) -> bool:
    return bool((values > ROUNDING).all())


def _drift(kind: str, drifts: dict[tuple[str, str], Slope], errors: pd.DataFrame) -> str:
    finest = errors[(errors["kind"] == kind) & (errors["step"] == errors["step"].min())].set_index("scheme")["drift"]
    names = [s for s in ("anitescu_potra", "stewart_trinkle", "moreau") if s in finest.index]
    told = [f"{s} {finest[s]:.1g} m" + (f", order {drifts[kind, s]}" if (kind, s) in drifts else "") for s in names]
    return f"{kind}, at the finest step: " + ", ".join(told)


def _draw(ax: Axes, own: pd.DataFrame, column: str) -> None:
    for k, (scheme, rows) in enumerate(own.groupby("scheme")):
        curve(ax, k, rows["step"], rows[column].clip(lower=ROUNDING), str(scheme))
    steps, top = np.sort(own["step"].unique()), own[column].max()
    for power in (1, 2):
        ax.plot(steps, top * (steps / steps[-1]) ** power, color="#20242b", lw=0.6, ls=":")
    finish(ax, "step, s", "m", "xy")


STUDY = Study((errors,), summary)
