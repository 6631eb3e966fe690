"""Are higher-order methods relevant? Orders of convergence of the schemes, and drift at contacts and joints."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import GRAVITY, SCHEMES, Scene, Scheme, Solve, Solved, Step, newton, simulation, start
from frictionbench.reports.drawing.figures import Panel
from studies.motions import REFERENCE_ACCURACY, by_events, coulomb, exact
from studies.study import Array, Row, Slope, Study, Summary, Tables, curve, finish, listing, order

ERROR_ROUNDING = 1e-10  # m: errors and drifts below it have no order
HIGHER = "trapezoid"
SLOPES_APART = 0.5  # largest difference between the slopes of the halves and the whole if the order has converged
HEIGHTS = tuple(0.2 + 0.02 * k for k in range(8))  # m, of the ball: when in a step it meets the ground varies
MOTIONS: dict[str, tuple[str, Sequence[dict[str, Any]], float]] = {
    # kind: scene, settings of each motion, and duration; no event falls on a step of all grids
    "pendulum": ("pendulum", [{}], 0.4),
    "smooth sliding": ("bowl", [{"friction": 0.1}], 0.4),
    "slip to stick": ("bowl", [{"friction": 0.3}], 1.2),
    "reversal": ("bowl", [{"friction": 0.1}], 1.2),
    "impacts": ("bouncing_ball", [{"height": height} for height in HEIGHTS], 0.8),
}
SAMPLE = 0.1  # s: positions are compared at its multiples
FRACTIONS = (5, 7, 10, 14, 20, 28, 40, 56)  # steps in SAMPLE: eight step sizes, each about 0.7 times the previous one


def trapezoid(scene: Scene, now: Step, solve: Solve) -> Step:
    """A half-explicit trapezoidal step, of second order between events, for at most one contact.

    The impulse r_0 = h lam of the reaction at q is that of an Euler step whose velocity stays tangent along the way,
    u = J(q) v+ + (n(q + h v) - n(q))'v, the term of J' in the constraint of accelerations. Then

        v_1 = v + h M^-1 k(q, v) + M^-1 J(q)'r_0,     q+ = q + h/2 (v + v_1),
        v+  = v + h/2 M^-1 [k(q, v) + k(q+, v_1)] + 1/2 M^-1 J(q)'r_0 + M^-1 J(q+)'r_1,

    with Coulomb's law between r_1 and J(q+) v+, and Newton's restitution at a contact that closes. A step over an impact is of
    first order, as the impact is moved to its end. After Brasey and Hairer 1993; Schindler, Rezaei, Kursawe and Acary 2015.
    """
    h, q, v = scene.step, now.q, now.v
    reach = scene.touch + h**2 * GRAVITY  # a closed contact drifts by O(h^2) to either side
    pull = scene.accelerate(q, scene.force(q, v, now.time))
    before, ahead = scene.contacts(q, reach), scene.moved(q, h * v)
    turned = scene.contacts(ahead, np.inf).normal[: len(before)]
    turning = (turned - before.normal) @ v
    first = scene.friction_problem(q, v + h * pull, before, bias=turning, joint_bias=scene.joints(ahead)[1] @ v)
    begun = Solved("step", first, solve(first), before)
    reached = first.velocity(begun.impulse)
    end = scene.moved(q, h / 2 * (v + reached))
    later = scene.accelerate(end, scene.force(end, reached, now.time + h))
    after = scene.contacts(end, reach)
    free = v + h / 2 * (pull + later) + (reached - v - h * pull) / 2
    rebound = scene.restitutions(after) * np.minimum(after.normal @ v, 0) * (len(before) == 0)
    second = scene.friction_problem(end, free, after, bias=rebound)
    ended = Solved("step", second, solve(second), after)
    return Step(now.time + h, end, second.velocity(ended.impulse), after, (begun, ended))


COMPARED: dict[str, Scheme] = {
    name: SCHEMES[name] for name in ("anitescu_potra", "stewart_trinkle", "moreau", "moreau_euler", "lotstedt", "acceleration")
} | {HIGHER: Scheme(trapezoid)}


def errors(
    schemes: Iterable[str] = tuple(COMPARED), fractions: Iterable[int] = FRACTIONS, kinds: Iterable[str] = tuple(MOTIONS)
) -> Iterator[Row]:
    """The body's position at multiples of SAMPLE compared with the event-driven scheme's, and the largest drift."""
    driven = by_events(newton, REFERENCE_ACCURACY)
    for kind, settings in ((one, each) for one in kinds for each in MOTIONS[one][1]):
        name, _, duration = MOTIONS[kind]
        whole = fb.scene(name, **settings, step=SAMPLE, duration=duration)
        # Each time is reached in one step, so that errors of the reference do not add up.
        ahead = [replace(whole, step=k * SAMPLE) for k in range(1, whole.steps + 1)]
        known = places(whole, [start(whole), *(driven(one, start(one), exact) for one in ahead)])
        for scheme in schemes:
            if COMPARED[scheme].refuses(whole):
                continue
            for fraction in fractions:
                stage = fb.scene(name, **settings, step=SAMPLE / fraction, duration=duration)
                run = list(simulation(stage, coulomb, COMPARED[scheme]))
                joints = max(float(np.abs(stage.joints(now.q)[0]).max(initial=0.0)) for now in run)
                yield {
                    "kind": kind,  # of motion
                    "height": settings.get("height"),  # of the ball, m
                    "scheme": scheme,  # time-stepping scheme
                    "step": stage.step,  # s
                    # the largest distance of the body's centre at these times, m
                    "error": float(np.linalg.norm(places(stage, run[::fraction]) - known, axis=1).max()),
                    # largest penetration or violation of a joint on the way, m
                    "drift": max(joints, *(stage.deepest_overlap(now.q) for now in run)),
                }


def places(scene: Scene, run: list[Step]) -> Array:
    """The centre (states, 2) of the one body."""
    return np.array([scene.geometry.centres(now.q)[0] for now in run])


def summary(tables: Tables) -> Summary:
    each = tables["errors"]
    errors = each.groupby(["kind", "scheme", "step"], sort=False)[["error", "drift"]].mean().reset_index()  # over the heights
    cases, dropped = errors.groupby(["kind", "scheme"]), each.groupby(["scheme", "height"])  # heights are of impacts alone
    single = pd.Series({key: order(group["step"], group["error"]).value for key, group in dropped}, dtype=float)
    slopes = {key: order(group["step"], group["error"]) for key, group in cases if (group["error"] > ERROR_ROUNDING).all()}
    drifts = {key: order(group["step"], group["drift"]) for key, group in cases if (group["drift"] > ERROR_ROUNDING).all()}
    kinds = list(dict.fromkeys(errors["kind"]))
    high = {kind: slopes[kind, HIGHER] for kind in kinds if (kind, HIGHER) in slopes}
    drifting = [kind for kind in ("pendulum", "smooth sliding") if kind in kinds]
    settled = {key for key, slope in slopes.items() if _settled(slope)}
    clear = {kind: slope for kind, slope in high.items() if (kind, HIGHER) in settled}
    lower = {kind: [slope.value for (k, s), slope in slopes.items() if k == kind and s != HIGHER] for kind in kinds}
    numbers = {
        "kept": listing([f"{kind} ({slope.value:.2f})" for kind, slope in clear.items() if min(slope) > 1.5]),
        "lost": listing([f"{kind} ({slope.value:.2f})" for kind, slope in clear.items() if max(slope) < 1.5]),
        "open": listing([kind for kind in high if kind not in clear]),
        "wide": listing([f"{s} in {k}" for k, s in slopes if (k, s) not in settled]),
        "lower": [f"{end(lower['smooth sliding']):.2f}" for end in (min, max)],
        "by_kind": "; ".join(
            f"{kind}: " + ", ".join(f"{s} {slopes[kind, s]}" for k, s in slopes if k == kind) for kind in kinds
        ),
        "count": len(HEIGHTS),
        "single": f"{single.min():.2f} to {single.max():.2f}",
        "singles": listing([f"{s} {of.min():.2f} to {of.max():.2f}" for s, of in single.groupby(level=0)]),
        "drift": "; ".join(_drift(kind, drifts, errors) for kind in drifting),
    }
    draw = partial(_draw, schemes=sorted(errors["scheme"].unique()))
    of_kind = {kind: errors[errors["kind"] == kind] for kind in kinds}
    figures = {
        "orders": tuple(Panel(kind, partial(draw, group=of_kind[kind], column="error")) for kind in kinds),
        "drift": tuple(Panel(f"drift, {kind}", partial(draw, group=of_kind[kind], column="drift")) for kind in drifting),
    }
    return Summary(numbers, figures)


def _settled(slope: Slope) -> bool:
    """Whether the slopes are near, and that of the whole, to a digit, between those of the halves: otherwise errors jump."""
    return max(slope) - min(slope) <= SLOPES_APART and min(slope[1:]) - 0.01 <= slope.value <= max(slope[1:]) + 0.01


def _drift(kind: str, drifts: dict[tuple[str, str], Slope], errors: pd.DataFrame) -> str:
    of_kind = errors[errors["kind"] == kind]
    finest = of_kind[of_kind["step"] == of_kind["step"].min()].set_index("scheme")["drift"]
    names = [s for s in ("anitescu_potra", "stewart_trinkle", "moreau", HIGHER) if s in finest.index]
    texts = [f"{s} {finest[s]:.1g} m" + (f", order {drifts[kind, s]}" if (kind, s) in drifts else "") for s in names]
    return f"{kind}, at the finest step: " + ", ".join(texts)


def _draw(ax: Axes, group: pd.DataFrame, column: str, schemes: list[str]) -> None:
    for scheme, rows in group.groupby("scheme"):
        curve(ax, schemes.index(str(scheme)), rows["step"], rows[column].clip(lower=ERROR_ROUNDING), str(scheme))
    steps, top = np.sort(group["step"].unique()), group[column].max()
    for power in (1, 2):
        ax.plot(steps, top * (steps / steps[-1]) ** power, color="#20242b", lw=0.6, ls=":")
    finish(ax, "step, s", "m", "xy")


STUDY = Study((errors,), summary)
