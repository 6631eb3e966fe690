"""The study of orders of convergence and of drift."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import curve, finish
from frictionbench.reports.studies.numbers import Slope, listing, order
from frictionbench.results.studies import StudyTables

ROUNDING = 1e-10  # m: errors and drifts below it have no order
BEYOND = 1.3  # an order whose interval lies above it is not the first


def account(found: StudyTables) -> Account:
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
    return Account(
        answer=(
            f"For {listing(gains)} some schemes are of second order; for {listing(lost)} none of those compared is."
            if gains and lost
            else f"No scheme that steps over events is clearly above first order (interval above {BEYOND:g}) in any motion, "
            f"smooth sliding included; nearest to it is {nearest[1]} in {nearest[0]}, {slopes[nearest]}."
            if not gains
            else "Second order is kept in every motion compared."
        ),
        result="Orders with 95 % intervals: "
        + "; ".join(f"{kind}: " + ", ".join(f"{s} {slopes[kind, s]}" for k, s in slopes if k == kind) for kind in kinds)
        + ". Drift by velocity, stabilised by gaps (stewart_trinkle) or at the middle of the step (moreau): "
        + "; ".join(_drift(kind, drifts, errors) for kind in ("pendulum", "smooth sliding") if kind in kinds)
        + ". "
        + (
            "All schemes have the same limit, to ten times their smallest error."
            if differing.empty
            else "Not all have the limit of the first scheme: "
            + listing([f"{s} in {kind} ({row['apart']:.1g} m apart)" for (kind, s), row in differing.iterrows()])
            + "."
        ),
        limits="All schemes compared step over events; one that locates them is not among them. The reference is only four "
        "times finer than the finest step, which raises a first order to about 1.1. The intervals measure how straight the "
        "line is over four steps, not the scatter of other motions. Errors are of positions at one time; where impacts shift "
        "in time, the error at one time depends on where between impacts it lies.",
        figures=(
            Figure(
                "orders",
                "Error of the position at the end against the step; dotted lines: orders one and two.",
                tuple(Panel(kind, partial(_draw, own=errors[errors["kind"] == kind], column="error")) for kind in kinds),
            ),
            Figure(
                "drift",
                "Largest violation of a joint (pendulum) and largest penetration (a bead in a bowl).",
                tuple(
                    Panel(f"drift, {kind}", partial(_draw, own=errors[errors["kind"] == kind], column="drift"))
                    for kind in ("pendulum", "smooth sliding")
                    if kind in kinds
                ),
            ),
        ),
    )


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
