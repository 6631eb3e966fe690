"""Is the solution set of a friction problem convex? Enumeration of all solutions of small problems."""

from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import Census, FrictionProblem, Shape, census, first_problem, is_p0, recorded_steps, simulation
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM, INK
from studies.motions import coulomb, thrown
from studies.study import Row, Study, Summary, Tables, finish, listing, require, share

BLUE = "#0077bb"
RESIDUAL_ROUNDING = 1e-12  # residuals below it are rounding
EXAMPLES = tuple(f"example_{number}" for number in range(1, 8))
MOST_CONTACTS = 5  # contacts of a problem whose solutions are enumerated, in a tenth of a second
SHAPES = {shape: shape.value.replace(" ", "_") for shape in Shape}


def jam(friction: float = 0.5, points: int = 41) -> Iterator[Row]:
    """Solutions of the jam in closed form, and the midpoints between each and the solution without impulses.

    Normal impulses c = s m V/(2 mu) on both walls leave the speed v = max(1 - s, 0) V; for s > 1 friction is below its limit.
    The gap z'w of the LCP is computed by hand: it is (mu c - beta) times the speed at both contacts.
    """
    problem = first_problem(fb.scene("jam", friction=friction))
    upwards, speed = problem.tangent.toarray()[:, 1], float(problem.free_velocity[1])
    for s in np.linspace(0, 2, points):
        normal = s * speed / (2 * friction)
        stopped = min(s, 1.0) * speed  # by the friction on both walls
        impulse = np.column_stack([np.full(2, normal), -upwards * stopped / 2])
        middle_speed = speed - stopped / 2
        yield {
            "share": s,  # normal impulse over the least one that stops the disc
            "normal": normal,  # normal impulse on each wall, N s
            "velocity": problem.velocity(impulse)[1],  # of the disc afterwards, m/s
            "residual": fb.residual(problem, impulse),  # of this solution
            "middle_residual": fb.residual(problem, impulse / 2),  # of the middle of this solution and of no impulse
            # z'w of that middle over m V^2, V the free velocity
            "middle_gap": 2 * (friction * normal / 2 - stopped / 4) * middle_speed / speed**2,
        }


def block(
    frictions: Iterable[float] = np.linspace(0.5, 4, 8), aspects: Iterable[float] = (0.25, 0.5, 1, 2, 4), draws: int = 150
) -> Iterator[Row]:
    """Random free velocities of a block on two corners, of uniform direction in the metric of the kinetic energy."""
    for aspect in aspects:
        for friction in frictions:
            problem = first_problem(fb.scene("two_corner_block", aspect=aspect, friction=friction))
            # The same draws at each point, so that neighbours differ by the problem alone.
            found = [census(one) for one in thrown(problem, draws, 0)]
            yield {
                "friction": friction,  # mu
                "aspect": aspect,  # height over width
                "p0": is_p0(problem),  # whether the LCP has a P0 matrix
                "draws": draws,  # free velocities
                **tally(found),
            }


def motions(names: Iterable[str] = EXAMPLES, steps: int | None = None, most: int = 60) -> Iterator[Row]:
    """The problems of simulated motions, at most `most` spread over each, and the recorded steps with few contacts.

    source: motion; problems: problems with one to 5 contacts; listed: those whose solutions are enumerated.
    """
    for name in names:
        met = [one.problem for step in simulation(fb.scene(name), coulomb, steps=steps) for one in step.solved]
        few = [problem for problem in met if 0 < problem.contacts <= MOST_CONTACTS]
        yield {"source": name, **counted(few[:: -(-len(few) // most) or 1])}
    kept = [fb.instance("recorded_step", case=case) for case in recorded_steps()]
    few = [problem for problem in kept if problem.dimension == 2 and 0 < problem.contacts <= MOST_CONTACTS]
    yield {"source": "recorded steps", **counted(few)}


def counted(problems: list[FrictionProblem]) -> Row:
    """Count the problems, those whose solutions are all enumerated, and the shapes of their solution sets."""
    found = [one for problem in problems if (one := listed(problem)) is not None]
    return {"problems": len(problems), "listed": len(found), **tally(found)}


def tally(found: list[Census]) -> Row:
    """Count the sets of impulses with each shape, and those with several velocities."""
    shapes = [one.shape for one in found]
    return {text: shapes.count(shape) for shape, text in SHAPES.items()} | {
        "several_velocities": sum(one.velocity_count != 1 and one.shape is not Shape.NONE for one in found),
        "most_velocities": max((one.velocity_count or 0 for one in found), default=0),
    }


def listed(problem: FrictionProblem) -> Census | None:
    """Enumerate all solutions; None if they cannot be distinguished because of rounding."""
    try:
        return census(problem)
    except ArithmeticError:
        return None


def summary(tables: Tables) -> Summary:
    jam, block, motions = (tables[name] for name in ("jam", "block", "motions"))
    inside, beyond = jam[jam["share"] <= 1], jam[jam["share"] > 1]
    require(jam["residual"].max() < RESIDUAL_ROUNDING, "the closed form solves the jam")
    require(inside["middle_residual"].max() < RESIDUAL_ROUNDING, "the sliding solutions of the jam form a segment")
    require((beyond["middle_residual"] > 1e-3).all(), "no middle with a sticking solution is a solution")
    several = block[block["several_velocities"] > 0]
    require(not several["p0"].any(), "a block with a P0 matrix has one velocity")
    high = block[block["several_velocities"] == block["several_velocities"].max()]  # of equal draws
    least = (several["friction"] * several["aspect"]).min()
    listed, odd = motions["listed"].sum(), (motions["isolated"] + motions["not_convex"]).sum()
    far = beyond.iloc[-1]
    numbers = {
        "most": block["most_velocities"].max(),
        "listed": listed,
        "points": len(jam),
        "residual": f"{jam['residual'].max():.0e}",
        "far": f"{far['share']:g}",
        "middle_residual": f"{far['middle_residual']:.2f}",
        "middle_gap": f"{far['middle_gap']:.3g}",
        "threshold": f"{least:.3g}",
        "mu": listing([f"{mu:.3g}" for mu in high["friction"]], "or"),
        "aspect": listing([f"{aspect:g}" for aspect in high["aspect"].unique()], "or"),
        "share": share(high["several_velocities"].iloc[0], high["draws"].iloc[0]),
        "sources": len(motions),
        "points_of_block": len(block),
        "unseen": share(0, int(high["draws"].iloc[0])),
        "problems": motions["problems"].sum(),
        "unique": motions["one"].sum(),
        "convex": motions["convex"].sum(),
        "odd": odd,
        "several": motions["several_velocities"].sum(),
    }
    figures = {
        "jam": (
            Panel("the solutions", partial(_bent, jam=jam)),
            Panel("their middles with no impulse", partial(_middles, jam=jam)),
        ),
        "block": (Panel("block on two corners", partial(_shares, block=block)),),
    }
    return Summary(numbers, figures)


def _bent(ax: Axes, jam: pd.DataFrame) -> None:
    slides = jam["share"] <= 1
    ax.plot(jam["normal"][slides], jam["velocity"][slides], color=BLUE, label="slides")
    ax.plot(jam["normal"][~slides], jam["velocity"][~slides], color=BLUE, ls="--", label="sticks, any larger impulse")
    ends = jam.iloc[[0, -1]][["normal", "velocity"]]
    ax.plot(ends["normal"], ends["velocity"], color=ALARM, lw=0.7, ls=":")
    ax.plot(*ends.mean(), "x", color=ALARM, label="no solution")
    finish(ax, "normal impulse, N s", "velocity afterwards, m/s")


def _middles(ax: Axes, jam: pd.DataFrame) -> None:
    ax.plot(jam["share"], jam["middle_residual"], color=BLUE, label="residual")
    ax.plot(jam["share"], jam["middle_gap"], color=INK, ls="--", label="z'w / (m V^2)")
    finish(ax, "normal impulse over the stopping one", "of the middle")


def _shares(ax: Axes, block: pd.DataFrame) -> None:
    rows = block.assign(share=100 * block["several_velocities"] / block["draws"])
    table = rows.pivot_table(index="aspect", columns="friction", values="share", sort=True)
    ax.imshow(table.to_numpy(float), cmap="Blues", vmin=0, origin="lower", aspect="auto")
    for (i, j), here in np.ndenumerate(table.to_numpy(float)):
        if here > 0:
            colour = "white" if here > 0.6 * table.max().max() else INK
            ax.text(j, i, f"{here:.2g}", ha="center", va="center", fontsize="x-small", color=colour)
    ax.set_xticks(range(table.shape[1]), [f"{at:.3g}" for at in table.columns])
    ax.set_yticks(range(table.shape[0]), [f"{at:.3g}" for at in table.index])
    edge = np.repeat(block.groupby("aspect")["p0"].sum() - 0.5, 2)
    ax.plot(edge, np.repeat(np.arange(-0.5, len(edge) / 2), 2)[1:-1], color=INK, ls="--")
    ax.set(xlabel="mu", ylabel="height over width")


STUDY = Study((jam, block, motions), summary)
