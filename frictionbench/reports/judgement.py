"""The page on an engine's judged steps: percentiles, violated laws, results of solvers, and the worst steps with their forces.

It is one self-contained file, made only from DIR/judgement.json and the table of solves. All text from these files is escaped.
"""

from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from frictionbench.reports.drawing.figures import PANEL, Panel
from frictionbench.reports.drawing.files import legend_size
from frictionbench.reports.drawing.style import ALARM, COLOURS, GRID, INK, WORST, ZERO, log_ticks, name_axes, residual_axis
from frictionbench.reports.drawing.text import plain
from frictionbench.reports.judged import CHOSEN_FROM, ENERGIES, PERCENTILES, QUANTITIES, read_judged
from frictionbench.reports.templates import write_page
from frictionbench.results.conventions import number
from frictionbench.results.judgement import LAWS, Judgement, NetImpulse

MOST_STEPS = 12  # worst steps in the table
SHOWN_AS_ZERO = 1e-9  # relative to the largest component of a net impulse: smaller ones are shown as 0
MOST_VELOCITIES = 12  # velocities whose net impulses are shown: as many as two free bodies in space have
MOST_DRAWN = 6  # worst steps with a picture of their forces
LEAST_DRAWN = 1e-14  # m/s: smaller violations are drawn here, where the axis says 0


def write_judgement(folder: Path) -> Path:
    """Write DIR/judgement.html; return its path. Errors: ResultsError if the folder holds no judgement."""
    judged = read_judged(folder)
    bad = judged.worst(MOST_STEPS)
    by_variant = judged.rows.drop_duplicates(["variant", "problem"]).set_index("problem").groupby("variant", sort=False)
    solved = {str(variant): rows for variant, rows in by_variant}
    return write_page(
        folder / "judgement.html",
        "judgement.html",
        name=judged.rows["scene"].iloc[0],
        judged=judged,
        heads=list(PERCENTILES),
        among=CHOSEN_FROM * MOST_STEPS,
        units=QUANTITIES | dict.fromkeys(ENERGIES, "J"),
        nets=[(one, name, _shown(net)) for one in bad[:MOST_DRAWN] for name, net in one.net_impulses.items()],
        worst=[
            (one, {variant: rows.reindex([one.problem]).iloc[0].to_dict() for variant, rows in solved.items()}) for one in bad
        ],
        panels=[
            Panel("residual of each step", partial(_residuals, judgements=judged.touching, solved=solved)),
            Panel("violation of each law, m/s", partial(_violations, judgements=judged.touching)),
        ],
        forces=[Panel(one.file, partial(_forces, one=one)) for one in bad[:MOST_DRAWN] if one.forces],
    )


def _shown(net: NetImpulse) -> dict[str, object]:
    """Return what the page shows of a net impulse, for the first MOST_VELOCITIES velocities."""
    which = "single contacts too" if net.each_determined else "the sum alone (hyperstatic)" if net.determined else "no"
    rounding = SHOWN_AS_ZERO * max(map(abs, net.engine + net.exact), default=0.0)
    shown = {"engine": net.engine[:MOST_VELOCITIES], "exact": net.exact[:MOST_VELOCITIES]}
    words = {name: ", ".join(number(value if abs(value) > rounding else 0.0) for value in own) for name, own in shown.items()}
    return net._asdict() | words | {"determined": which}


def _residuals(ax: Axes, judgements: list[Judgement], solved: dict[str, pd.DataFrame]) -> None:
    """Plot the engine's residuals step by step, and those of the solvers."""
    at = np.arange(1, len(judgements) + 1)
    ax.plot(at, np.clip([one.residual for one in judgements], ZERO, WORST), color=ALARM, marker=".", label="the engine")
    for k, (variant, rows) in enumerate(solved.items()):
        by_problem = rows["residual"].reindex([one.problem for one in judgements]).to_numpy(float)
        ax.plot(at, np.clip(by_problem, ZERO, WORST), color=COLOURS[k % len(COLOURS)], marker=".", label=plain(variant))
    residual_axis(ax)
    ax.set_ylim(ZERO / 3, WORST * 3)
    _steps(ax, "verified residual")


def _violations(ax: Axes, judgements: list[Judgement]) -> None:
    at = np.arange(1, len(judgements) + 1)
    for colour, law in zip(COLOURS, LAWS, strict=False):
        values = np.array([one.known(law) for one in judgements])
        if values.any():
            ax.plot(at, np.clip(values, LEAST_DRAWN, None), color=colour, marker=".", label=law)
    log_ticks(ax, "y", {10.0**k: f"1e{k}" for k in range(2, -13, -2)} | {LEAST_DRAWN: "0"})
    ax.set_ylim(LEAST_DRAWN / 3, 1e3)
    _steps(ax, "m/s")


def _steps(ax: Axes, measured: str) -> None:
    """Add the axes' names and the legend to a plot over the steps."""
    ax.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
    name_axes(ax, "step with contacts", measured, grid="y")
    if names := ax.get_legend_handles_labels()[1]:
        across, _ = legend_size(names, PANEL[0], rcParams["font.size"])
        ax.figure.legend(loc="outside upper center", ncols=across)  # above the axes, where it hides no curve


def _forces(ax: Axes, one: Judgement) -> None:
    """Plot each contact's friction over its limit against its normal impulse."""
    normal, tangential, limit = np.array(one.forces).T
    share = tangential / np.where(limit > 0, limit, np.inf)
    ax.plot(normal, share, "o", color=COLOURS[0], ms=4)
    ax.axhline(1, color=INK, lw=0.8, ls="--")
    ax.axvline(0, **GRID)  # shows also where impulses differ little how large they are
    ax.xaxis.set_major_locator(MaxNLocator(4))
    ax.set_ylim(0, max(1.15, 1.1 * float(share.max(initial=0))))
    name_axes(ax, "normal impulse, N s", "friction / limit")
