"""Independent coordinates or multipliers? A slider-crank in three angles and on three hinges."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, simulation
from frictionbench.reports.drawing.figures import Panel
from studies.motions import exact
from studies.slider_crank import SliderCrankAngles
from studies.study import Array, Row, Study, Summary, Tables, finish, listing, order, require

NAMES = {"angles": "slider_crank_angles", "hinges": "slider_crank"}
SPEEDS = {150.0: 0.004, 10.0: 0.04, 1.0: 0.02}  # of the crank, rad/s, and durations, s


def places(form: str, scheme: str, step: float, duration: float, **settings: float) -> list[Array]:
    """Return the bodies' coordinates (9,) at the start and after each step."""
    made = fb.scene(NAMES[form], step=step, duration=duration, **settings)
    run = [now.q for now in simulation(made, exact, SCHEMES[scheme])]
    return [made.place(q) for q in run] if isinstance(made, SliderCrankAngles) else run


def drifts(
    schemes: Iterable[str] = ("anitescu_potra", "moreau", "stewart_trinkle"),
    counts: Iterable[int] = (100, 200, 400, 800),
    duration: float = 0.04,
) -> Iterator[Row]:
    """Drift at the hinges, and distance from the event-driven motion, in the two forms."""
    end, full = places("angles", "event_driven_newton", duration, duration)[-1], fb.scene(NAMES["hinges"])
    for scheme, count, form in product(schemes, counts, NAMES):
        bodies = places(form, scheme, duration / count, duration)
        yield {
            "scheme": scheme,
            "step": duration / count,  # s
            "form": form,  # angles or hinges
            "drift": max(float(np.abs(full.joints(q)[0]).max()) for q in bodies),  # the largest gap of a hinge, m
            "error": float(np.abs(bodies[-1] - end).max()),  # of a body's coordinate at the end, m or rad
        }


def free(
    schemes: Iterable[str] = ("anitescu_potra", "moreau", "stewart_trinkle"),
    counts: Iterable[int] = (10, 20, 40, 80, 160),
) -> Iterator[Row]:
    """The same mechanism with enough clearance that nothing touches: the order of each scheme in each form."""
    for speed, duration in SPEEDS.items():
        wide = {"clearance": 0.01, "speed": speed}
        end = places("angles", "event_driven_newton", duration, duration, **wide)[-1]
        for scheme, count, form in product(schemes, counts, NAMES):
            yield {
                "speed": speed,  # of the crank at the start, rad/s
                "scheme": scheme,
                "step": duration / count,  # s
                "form": form,  # angles or hinges
                # of a body's coordinate at the end, m or rad
                "error": float(np.abs(places(form, scheme, duration / count, duration, **wide)[-1] - end).max()),
            }


def summary(tables: Tables) -> Summary:
    drifts, free = tables["drifts"], tables["free"]
    slow = free[(free["form"] == "hinges") & (free["scheme"] == "stewart_trinkle")].groupby("speed")
    angles, hinges = (drifts[drifts["form"] == form] for form in ("angles", "hinges"))
    require(angles["drift"].max() < 1e-12, "nothing drifts in angles")
    slopes = {scheme: order(rows["step"], rows["drift"]) for scheme, rows in hinges.groupby("scheme")}
    paired = angles.merge(hinges, on=["scheme", "step"], suffixes=("", "_hinges"))
    finest = paired[paired["step"] == paired["step"].min()]
    numbers = {
        "drift": f"{hinges['drift'].max():.0e}",
        "finest": finest.assign(order=finest["scheme"].map(slopes)).to_dict("records"),
        "free": "; ".join(f"{form}: {_orders(rows)}" for form, rows in free[free["speed"] == max(SPEEDS)].groupby("form")),
        "slow": listing([f"{order(rows['step'], rows['error'])} at {speed:g} rad/s" for speed, rows in slow]),
    }
    figures = {
        "drift": (
            Panel("drift", partial(_draw, rows=hinges, column="drift")),
            Panel("error", partial(_draw, rows=drifts, column="error")),
        )
    }
    return Summary(numbers, figures)


def _orders(rows: pd.DataFrame) -> str:
    return ", ".join(f"{scheme} {order(group['step'], group['error'])}" for scheme, group in rows.groupby("scheme"))


def _draw(ax: Axes, rows: pd.DataFrame, column: str) -> None:
    for number, (scheme, of) in enumerate(rows.groupby("scheme")):
        for form, one in of.groupby("form"):
            line = "o--" if form == "angles" else "o-"
            ax.plot(one["step"], one[column], line, color=f"C{number}", ms=4, label=f"{scheme}, {form}")
    finish(ax, "step, s", "gap of a hinge, m" if column == "drift" else "error at the end, m or rad", "xy")


STUDY = Study((drifts, free), summary)
