"""Maximum dissipation with several contacts: all solutions ranked by kinetic energy, and which solver returns which."""

from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from scipy.optimize import lsq_linear

import frictionbench as fb
from frictionbench.problems import FrictionProblem, census, first_problem
from frictionbench.reports import INK, Panel
from frictionbench.solvers import solve
from studies.motions import thrown
from studies.study import COLOURS, Array, Row, Study, Summary, Tables, finish, listing, require, share

ROUNDING = 1e-6  # of the free motion's energy
SOLVERS = (  # of the exact law
    *("lemke", "path_search", "interior_point", "nsgs", "fischer_newton", "minmap_newton", "dantzig", "murty"),
    *("staggered", "nncg", "anitescu_hart", "apgd_coulomb", "admm_coulomb"),
)
CORNERS = ((1.0, 2.5), (1.0, 3.5), (2.0, 2.5), (2.0, 3.5))  # (height over width, mu) of a block
SAME = 1e-6  # velocities closer than this, over the free one, are one solution's


def ambiguous(draws: int = 120, angles: Iterable[float] = (1.0, 1.1, 1.2, 1.3)) -> Iterator[tuple[str, FrictionProblem]]:
    """Problems with several isolated solutions: thrown blocks, and Painlevé's rod whose tip lifts."""
    for aspect, friction in CORNERS:
        block = first_problem(fb.scene("two_corner_block", aspect=aspect, friction=friction))
        for one in thrown(block, draws, 1):
            if (census(one).velocity_count or 1) > 1:
                yield "block", one
    for angle in angles:
        for friction in (1.6, 2.2, 3.0):
            rod = first_problem(fb.scene("painleve_rod", angle=angle, friction=friction, lift=0.002, step=1e-4))
            if (census(rod).velocity_count or 1) > 1:
                yield "rod", rod


def solutions(draws: int = 120, angles: Iterable[float] = (1.0, 1.1, 1.2, 1.3)) -> Iterator[Row]:
    """Every solution of every such problem, the one of least energy first.

    least: the energy that friction impulses within the cones of the solution's own normal impulses can reach at least, by
    bounded least squares; the principle holds for all contacts together where it equals the solution's own.
    """
    for number, (kind, problem) in enumerate(ambiguous(draws, angles)):
        found = [piece.vertices.mean(axis=0).reshape(-1, 2) for piece in census(problem).pieces]
        energies = [energy(problem, problem.velocity(impulse)) for impulse in found]
        at_first = energy(problem, problem.free_velocity)
        for rank, k in enumerate(np.argsort(energies), start=1):
            yield {
                "number": number,  # of the problem
                "kind": kind,  # block or rod
                "contacts": problem.contacts,  # number of contacts
                "rank": rank,  # of the solution by its kinetic energy, 1 the least
                "of": len(found),  # number of solutions
                "energy": energies[k] / at_first,  # kinetic energy it leaves over that of the free motion
                # least energy with its normal impulses and any friction within the cones, over the same
                "least": most_dissipated(problem, found[k][:, 0]) / at_first,
                "residual": fb.residual(problem, found[k]),  # of the solution
            }


def most_dissipated(problem: FrictionProblem, normal: Array) -> float:
    """The least kinetic energy, J, after friction impulses |r_t| <= mu r_n beside these normal impulses (nc,)."""
    root = np.sqrt(problem.mass.diagonal())  # bodies in the plane: a diagonal matrix
    limit = problem.friction * normal + 1e-12
    pushed = root * problem.free_velocity + problem.normal.T @ normal / root
    result = lsq_linear((problem.tangent.toarray() / root).T, -pushed, (-limit, limit), tol=1e-14)
    return float(result.cost)


def returned(
    draws: int = 120, angles: Iterable[float] = (1.0, 1.1, 1.2, 1.3), solvers: Iterable[str] = SOLVERS
) -> Iterator[Row]:
    """Which solution each solver returns, by its rank; null where its answer is none."""
    for number, (kind, problem) in enumerate(ambiguous(draws, angles)):
        known = [problem.velocity(piece.vertices.mean(axis=0)) for piece in census(problem).pieces]
        known.sort(key=lambda v: energy(problem, v))
        for solver in solvers:
            answer = solve(problem, solver, tol=1e-9)
            v = problem.velocity(answer.impulse)
            away = [np.sqrt(energy(problem, v - w) / energy(problem, problem.free_velocity)) for w in known]
            solved = fb.residual(problem, answer.impulse) <= 1e-8 and min(away) <= SAME
            yield {
                "number": number,  # of the problem
                "kind": kind,  # block or rod
                "of": len(known),  # number of solutions
                "solver": solver,  # exact solver
                # of the solution that it returns, null where its answer is none to 1e-8
                "rank": int(np.argmin(away)) + 1 if solved else None,
            }


def energy(problem: FrictionProblem, v: Array) -> float:
    """The kinetic energy, J, of velocities (nv,)."""
    return float(v @ (problem.mass @ v)) / 2


def summary(found: Tables) -> Summary:
    solutions, returned = found["solutions"], found["returned"]
    gap = (solutions["energy"] - solutions["least"]).abs().max()
    require(solutions["residual"].max() < 1e-7, "all listed solutions are solutions")
    require(gap < ROUNDING, "every solution dissipates most for its own normal impulses")
    problems = solutions.groupby("number").first()
    ties = solutions.groupby("number")["energy"].apply(lambda energies: np.diff(np.sort(energies)).min())
    answered = returned[returned["rank"].notna()]
    first = answered.assign(first=answered["rank"] == 1).groupby("solver")["first"].agg(["sum", "count"])
    order = (first["sum"] / first["count"]).sort_values(ascending=False)
    never = [str(name) for name in order.index if order[name] == 0]
    silent = int(returned["rank"].isna().sum())
    ranks = sorted(answered["rank"].astype(int).unique())
    counts = [str(count) for count in sorted(problems["of"].unique())]
    best, worst = order.index[0], order.index[-1]
    numbers = {
        "least_share": f"{first['sum'].sum() / first['count'].sum():.0%}",
        "solvers_finding": len(order) - len(never),
        "solvers": len(order),
        "problems": len(problems),
        "counts": listing(counts, "or"),
        "gap": f"{gap:.0e}",
        "ties": f"{ties.min():.0e}",
        "best": best,
        "best_share": share(*first.loc[best, ["sum", "count"]]),
        "worst": worst,
        "worst_share": share(*first.loc[worst, ["sum", "count"]]),
        "several_never": len(never) > 1,
        "never": listing(never),
        "first_rank": ranks[0],
        "last_rank": ranks[-1],
        "silent": silent,
        "answers": len(returned),
    }
    figures = {
        "energies": (
            Panel("energy of the solutions", partial(_energies, solutions=solutions)),
            Panel("returned", partial(_returned, returned=returned)),
        ),
    }
    return Summary(numbers, figures)


def _energies(ax: Axes, solutions: pd.DataFrame) -> None:
    for rank, own in solutions.groupby("rank"):
        ax.plot(own["number"], own["energy"], "o", color=COLOURS[int(rank) - 1], ms=3, label=f"rank {rank}")
    finish(ax, "problem", "energy left, share")


def _returned(ax: Axes, returned: pd.DataFrame) -> None:
    table = returned.assign(rank=returned["rank"].fillna(0)).pivot_table(
        index="solver", columns="rank", values="number", aggfunc="count", fill_value=0
    )
    table = table.div(table.sum(axis=1), axis=0)
    left = np.zeros(len(table))
    for rank in sorted(table.columns):
        colour = COLOURS[int(rank) - 1] if rank else "none"
        ax.barh(
            table.index, table[rank], left=left, color=colour, edgecolor=INK, lw=0.3, label=f"rank {rank:g}" if rank else "_"
        )
        left += table[rank].to_numpy(float)
    finish(ax, "share of problems", "", xlim=(0, 1))


STUDY = Study((solutions, returned), summary)
