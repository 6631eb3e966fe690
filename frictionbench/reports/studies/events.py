"""The study of the event-driven scheme: error against work beside time stepping, and where it ends."""

import json
from functools import partial
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import curve, finish
from frictionbench.reports.studies.numbers import order
from frictionbench.results.studies import StudyTables

EVENTS = "event_driven"
LEAST = 1e-15  # errors below it are drawn there


def account(found: StudyTables) -> Account:
    errors, ends = found["errors"], found["ends"]
    driven, stepped = errors[errors["scheme"] == EVENTS], errors[errors["scheme"] != EVENTS]
    found.require(driven["error"].notna().all(), "the event-driven scheme follows all scenes")
    whole, names = stepped.dropna(subset="error"), list(dict.fromkeys(errors["scene"]))
    best = [_best(name, driven, whole) for name in names]
    smaller = [row for row in best if row["error"] < row["stepped"]]
    cheaper = [row for row in smaller if row["work"] < row["steps"]]
    stopped = ends[ends["reason"] != ""]
    told = "; ".join(
        f"{row['scene']}, {row['error']:.0e} by {row['work']} evaluations beside {row['stepped']:.0e} by {row['steps']} "
        f"({row['scheme']})"
        for row in best
    )
    orders = pd.Series([order(own["setting"], own["error"]).value for _, own in whole.groupby(["scene", "scheme"])])
    low, middle, high = orders.quantile([0.25, 0.5, 0.75])
    return Account(
        answer=f"Event-driven while events are few: in {len(smaller)} of {len(names)} scenes its error is below that of every "
        f"time-stepping scheme at every step, in {len(cheaper)} of them with fewer evaluations than the most accurate of "
        f"these. It followed {len(ends) - len(stopped)} of {len(ends)} motions to the end.",
        result=f"Errors of the event-driven scheme at the middle accuracy of its integrator, beside the smallest of time "
        f"stepping: {told}. The orders of time stepping in the step have the quartiles {low:.1f}, {middle:.1f} and {high:.1f}; "
        f"{len(stepped) - len(whole)} of its {len(stepped)} motions ended without a solution. By events, "
        f"{int(ends['impacts'].sum())} impacts were located in all, and {int(ends['accumulations'].sum())} accumulation "
        "of impacts was passed, where a single contact bounces."
        + "".join(
            f" {row.scene}{_settings(row.parameters)} ended between {row.reached:.3g} and "
            f"{row.reached + row.duration / 10:.3g} s: {row.reason}."
            for row in stopped.itertuples()
        ),
        limits="Evaluations are not seconds: one between events is a small linear system, and a friction problem of a step has "
        "inequalities besides. The scenes have few contacts; with many, events are as frequent as steps. The reference is the "
        "scheme's own motion at a finer accuracy, so an event that it misses at every accuracy would not be seen here. That a "
        "motion reached its end does not say that it was the only one.",
        figures=(
            Figure(
                "work",
                "The largest error of a coordinate against friction problems and evaluations of forces.",
                tuple(
                    Panel(name.replace("_", " "), partial(_work, errors=errors[errors["scene"] == name].dropna(subset="error")))
                    for name in names
                ),
            ),
        ),
    )


def _best(name: str, driven: pd.DataFrame, whole: pd.DataFrame) -> dict[str, Any]:
    """The event-driven scheme at its middle accuracy and the most accurate time-stepping motion of a scene."""
    own = driven[driven["scene"] == name].sort_values("setting")
    chosen, best = own.iloc[len(own) // 2], whole[whole["scene"] == name].sort_values("error").iloc[0]
    facts = {"scene": name.replace("_", " "), "error": chosen["error"], "work": int(chosen["work"])}
    return facts | {"stepped": best["error"], "steps": int(best["work"]), "scheme": best["scheme"]}


def _settings(parameters: str) -> str:
    named = ", ".join(f"{name}={value:g}" for name, value in json.loads(parameters).items())
    return f" ({named})" if named else ""


def _work(ax: Axes, errors: pd.DataFrame) -> None:
    for k, (scheme, own) in enumerate(errors.groupby("scheme")):
        ordered = own.sort_values("work")
        curve(ax, k, ordered["work"], ordered["error"].clip(lower=LEAST), str(scheme))
    finish(ax, "evaluations", "largest error, m or rad", "xy")
