"""The study of convergence as the step shrinks."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.lines import curve, finish
from frictionbench.reports.studies.numbers import listing
from frictionbench.results.studies import StudyTables

SMALL = 0.05  # a last change below this share of the quantity, and below the one before, counts as settling
APART = 0.01  # m/s, or a share of normal impulses: more is another answer
ROUNDING = 1e-6  # m/s or N s: changes below it are rounding
ROD = 0.9  # N s: the normal impulse that stops the rod in the limit, 3/4 m sin cos |v_t|


def account(found: StudyTables) -> Account:
    rows = found["refinement"].sort_values("step", ascending=False)
    found.require((rows["squares"] <= rows["bound"] * (1 + 1e-6) + 1e-9).all(), "the ledger bounds the squared impulses")
    settled = pd.DataFrame(
        [
            {"scene": scene, "solver": solver}
            | {name: _settles(own[name]) for name in ("net", "velocity", "normal", "variation")}
            | {"grows": float(own["variation"].iloc[-1] / own["variation"].iloc[0])}
            for (scene, solver), own in rows.groupby(["scene", "solver"])
        ]
    )
    finest = rows[rows["step"] == rows["step"].min()]
    spread = finest.groupby("scene").agg(
        normal=("normal", np.ptp), middle=("normal", "median"), net=("net", _apart), velocity=("velocity", _apart)
    )
    parted = spread[spread["velocity"] > APART]
    loose = spread[(spread["velocity"] <= APART) & (spread["normal"] > APART * spread["middle"])]
    both = settled["net"] & settled["velocity"]
    steady, restless = int(both.sum()), [f"{row['scene']} by {row['solver']}" for row in settled[~both].to_dict("records")]
    rod, largest = finest[(finest["scene"] == "rod")]["largest"], settled["grows"].max()
    return Account(
        answer=f"Each solver's sequence settles in {steady} of {len(settled)} cases, and the velocity's variation grows to at "
        f"most {largest:.2f} times its size as the step falls to a sixteenth"
        + (f"; but in {listing([*parted.index])} different solvers settle on different motions." if len(parted) else "."),
        result=f"Between the last two steps the net impulse and the velocity at the end change by less than "
        f"{100 * SMALL:.0f} % in {steady} of {len(settled)} pairs of a scene and a solver"
        + (f"; not in {listing(restless)}" if restless else "")
        + f". The impulse that stops the rod's tip is {rod.min():.4f} to {rod.max():.4f} N s at the smallest step; the "
        f"closed form of the limit has {ROD:g}. The sum of |J'r|^2/2 stays below the energy at the start and the work done in "
        f"all {len(rows)} motions, at {(rows['squares'] / rows['bound']).max():.2f} of it at most. This alone bounds the sum "
        "of |J'r| only by the root of the number of steps; measured, the variation of the velocity hardly grows."
        + "".join(
            f" In the scene {name} the solvers part: their velocities at the smallest step are up to {row['velocity']:.2g} "
            "apart, while each sequence settles: the limit is not unique there."
            for name, row in parted.iterrows()
        )
        + "".join(
            f" In the scene {name} the sums of normal impulses differ by {100 * row['normal'] / row['middle']:.0f} % between "
            f"solvers, the net impulses by {row['net']:.0e} only: normals that cancel have no limit of their own."
            for name, row in loose.iterrows()
        ),
        limits="Four scenes and a sequence of five steps prove no convergence, and no rate is claimed. That a limit satisfies "
        "the differential inclusion was checked for the rod's impulse only. A bound on the variation for all scenes whose cone "
        "is not pointed remains open.",
        figures=(
            Figure(
                "refinement",
                "Against the step, by solver: the sum of all normal impulses over that at the smallest step by lemke (left), "
                "and the variation of the velocity over that at the largest step (right).",
                (
                    Panel("normal impulses", partial(_draw, rows=rows, column="normal")),
                    Panel("variation of the velocity", partial(_draw, rows=rows, column="variation")),
                ),
            ),
        ),
    )


def _apart(values: pd.Series) -> float:
    """The largest distance between any two of the vectors."""
    vectors = np.array([np.atleast_1d(value) for value in values], dtype=float)
    return float(np.linalg.norm(vectors[:, None] - vectors[None], axis=2).max())


def _settles(values: pd.Series) -> bool:
    vectors = np.array([np.atleast_1d(value) for value in values], dtype=float)
    return bool(np.linalg.norm(vectors[-1] - vectors[-2]) <= max(SMALL * np.abs(vectors).max(), ROUNDING))


def _draw(ax: Axes, rows: pd.DataFrame, column: str) -> None:
    for k, (scene, own) in enumerate(rows.groupby("scene")):
        lemke = own[own["solver"] == "lemke"][column]
        unit = (lemke.iloc[-1] if column == "normal" else lemke.iloc[0]) or 1.0
        for j, (_, curve_of) in enumerate(own.groupby("solver")):
            curve(ax, k, curve_of["step"], curve_of[column] / unit, str(scene) if not j else "", lw=1.2 - 0.4 * j)
    finish(ax, "step, s", "relative", "x")
