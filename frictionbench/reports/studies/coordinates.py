"""The study of independent coordinates: drift and error with and without hinges, and what the solvers see."""

from functools import partial

import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import GRID
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.numbers import order
from frictionbench.results.studies import StudyTables

SAME = 1e-9  # relative difference of matrices up to which they are the same


def account(found: StudyTables) -> Account:
    drifts, problems = found["drifts"], found["problems"]
    angles, hinges = (drifts[drifts["form"] == form] for form in ("angles", "hinges"))
    found.require(problems["difference"].max() < SAME, "both forms give the solvers the same Delassus matrices")
    found.require(angles["drift"].max() < 1e-12, "nothing drifts in angles")
    slopes = {scheme: order(rows["step"], rows["drift"]) for scheme, rows in hinges.groupby("scheme")}
    paired = angles.merge(hinges, on=["scheme", "step"], suffixes=("", "_hinges"))
    finer = paired[paired["step"] == paired["step"].min()]
    ratio = (paired["seconds"] / paired["seconds_hinges"]).quantile([0.25, 0.5, 0.75])
    first = problems.iloc[0]
    told = ", ".join(
        f"{scheme} {hinges[hinges['scheme'] == scheme]['drift'].min():.0e} m (order {slope})"
        for scheme, slope in slopes.items()
    )
    ends = ", ".join(
        f"{row.scheme} {row.error:.1e} in angles and {row.error_hinges:.1e} on hinges" for row in finer.itertuples()
    )
    counts = ", ".join(f"{row.solver} {row.work_angles} and {row.work_hinges}" for row in problems.itertuples())
    return Account(
        answer=f"To the solvers it is the same: the Delassus matrices of {first['problems']} contact problems differ by "
        f"{problems['difference'].max():.0e}. Coordinates do not drift, hinges do by up to {hinges['drift'].max():.0e} m.",
        result=f"A step has {first['velocities_angles']} velocities in angles; on hinges it has {first['velocities_hinges']} "
        f"and "
        f"{first['joints_hinges']} joint equations. Drift on hinges at the finest step: {told}; in angles it is below 1e-12 "
        f"m. Errors "
        f"at the end, at the finest step: {ends}. Work counters of the solvers on the same states, in angles and on hinges: "
        f"{counts}. A step in angles takes {ratio[0.5]:.2f} times as long as on hinges (half of the ratios from "
        f"{ratio[0.25]:.2f} to "
        f"{ratio[0.75]:.2f}), with contact finding in Python in both.",
        limits="One mechanism, in the plane, with a dense mass matrix of three rows: a long chain in such coordinates has "
        "a dense one of its own size, where hinges remain sparse. Errors include those of impacts.",
        figures=(
            Figure(
                "drift",
                "Left: the largest gap of a hinge; right: the error at the end, in angles (dashed) and on hinges.",
                (Panel("drift", partial(_drift, hinges=hinges)), Panel("error", partial(_error, drifts=drifts))),
            ),
        ),
    )


def _drift(ax: Axes, hinges: pd.DataFrame) -> None:
    for scheme, rows in hinges.groupby("scheme"):
        ax.loglog(rows["step"], rows["drift"], "o-", ms=4, label=str(scheme))
    ax.set(xlabel="step, s", ylabel="gap of a hinge, m")
    ax.grid(**GRID)
    ax.legend()


def _error(ax: Axes, drifts: pd.DataFrame) -> None:
    for number, (scheme, rows) in enumerate(drifts.groupby("scheme")):
        for form, one in rows.groupby("form"):
            line = "o--" if form == "angles" else "o-"
            ax.loglog(one["step"], one["error"], line, color=f"C{number}", ms=4, label=f"{scheme}, {form}")
    ax.set(xlabel="step, s", ylabel="error at the end, m or rad")
    ax.grid(**GRID)
    ax.legend()
