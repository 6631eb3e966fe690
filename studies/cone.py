"""The Coulomb cone itself or a polygon: error and time against the number of facets."""

from collections.abc import Iterable, Iterator
from functools import partial

import clarabel
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from scipy import sparse

import frictionbench as fb
from frictionbench.harness import Source
from frictionbench.problems import FrictionProblem, simulation
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.solvers import solve
from studies.motions import apart
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, order, require

KINK = 1e-9  # errors below it are rounding
DISTINCT = 1e-4  # solutions further apart are two, and not one to a few digits
CONE, TOL = "interior_point", 1e-10
SLIDING = 0.236  # s, until the ball rolls
FACETS = (4, 6, 8, 12, 16, 24, 32, 64)
TURNS = 8  # orientations of each polygon, evenly over the angle of a facet
SPACE = (
    Source("cubes", {"boxes": 2, "friction": 0.2, "push": 0.5, "twist": 2.0, "fall": 1.0}),
    Source("sphere_pyramid", {"levels": 2, "friction": 0.1, "noise": 0.3}),
    Source("random_bodies", {"contacts": 8, "seed": 1}),
    Source("random_bodies", {"contacts": 20}),
    Source("rod_chain", {"links": 4}),
    Source("packed_spheres", {"spheres": 15, "noise": 1.0}),
)


def turned(problem: FrictionProblem, angle: float, spec: str, tol: float) -> Array:
    """The impulses (nc, 3) by a solver whose polygon has its first corner at this angle from the first tangent."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    rows = problem.tangent.toarray().reshape(problem.contacts, 2, -1)
    frame = problem.replace(tangent=np.einsum("ab,ibv->iav", turn, rows).reshape(2 * problem.contacts, -1))
    r = solve(frame, spec, tol=tol).impulse
    return np.column_stack([r[:, :1], r[:, 1:] @ turn])


def orientations(facets: int, turns: int) -> Array:
    """Angles of a polygon's first corner, evenly over the angle of a facet; one for the cone."""
    return 2 * np.pi / facets * np.arange(turns) / turns if facets else np.zeros(1)


def ball(facets: Iterable[int] = (0, *FACETS), step: float = 0.004, shown: int = 40, turns: int = TURNS) -> Iterator[Row]:
    """A sliding ball with a side spin: some points of its path, and its distances from the parabola; 0 facets for the cone."""
    stage = fb.scene("sliding_ball", step=step, duration=SLIDING)
    assert stage.path is not None
    parabola = np.vstack([stage.path(k * step) for k in range(stage.steps + 1)])

    def path(spec: str, angle: float = 0.0) -> Array:
        answer = partial(turned, angle=angle, spec=spec, tol=1e-9)
        return np.vstack([stage.geometry.centres(now.q) for now in simulation(stage, answer)])

    cone = path(CONE)
    for count, angle in ((polygon, turn) for polygon in facets for turn in orientations(polygon, turns)):
        found = path(f"lemke[facets={count}]", angle) if count else cone
        pick = np.linspace(0, len(found) - 1, shown).astype(int)
        yield {
            "facets": count,  # of the polygon, 0 for the cone
            "angle": angle,  # of the polygon's first corner, rad
            "step": step,  # s
            # largest distance of the path from the parabola, m
            "from_parabola": float(np.linalg.norm(found - parabola, axis=1).max()),
            # largest distance of the path from that with the cone, m
            "from_cone": float(np.linalg.norm(found - cone, axis=1).max()),
            "x": found[pick, 0],  # points of the path, m
            "y": found[pick, 1],  # points of the path, m
            # their distance from the parabola across its chord, m
            "aside": (found - parabola)[pick, :2] @ _across(parabola[:, :2]),
        }


def _across(path: Array) -> Array:
    """The unit vector across the chord of a path in the plane."""
    chord = path[-1] - path[0]
    return np.array([-chord[1], chord[0]]) / np.linalg.norm(chord)


def problems(facets: Iterable[int] = FACETS[:-1], sources: Iterable[Source] = SPACE, turns: int = TURNS) -> Iterator[Row]:
    """Spatial problems by the cone and by polygons: the residual of Coulomb's law and the velocities' error.

    A problem may have several solutions; the second is found by refining the finest polygon's answer on the cone.
    """
    for number, source in enumerate(sources):
        problem = fb.instance(source.scene, **source.parameters)
        found = {
            (count, angle): turned(problem, angle, f"lemke[facets={count}]", TOL)
            for count in facets
            for angle in orientations(count, turns)
        }
        finest = found[max(found)]
        exact = [solve(problem, CONE, tol=TOL).impulse, solve(problem, "proximal_newton", tol=TOL, start=finest).impulse]
        velocities = [problem.velocity(impulse) for impulse in exact if fb.residual(problem, impulse) <= TOL]
        for (count, angle), impulse in found.items():
            v = problem.velocity(impulse)
            yield {
                "number": number,  # of the problem
                "scene": source.scene,  # instance
                "contacts": problem.contacts,  # number of contacts
                "facets": count,  # of the polygon
                "angle": angle,  # of its first corner, rad
                "unknowns": problem.contacts * (count + 2),  # of the LCP
                "residual": fb.residual(problem, impulse),  # of Coulomb's law
                # |v - v_cone|_M / |v*|_M to the nearer of the known solutions with the cone
                "error": min(apart(problem, v, known) for known in velocities),
                # the same between these: above 0 there are two
                "solutions_apart": apart(problem, velocities[0], velocities[-1]),
            }


def interior(facets: Iterable[int] = (0, *FACETS), sources: Iterable[Source] = SPACE, repeats: int = 7) -> Iterator[Row]:
    """One interior point method, Clarabel, on the convex relaxation of the same problems with the cone and with polygons.

    The relaxation has both forms, so that here only the model of the cone differs. 0 facets stand for the cone.
    """
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    for number, source in enumerate(sources):
        problem = fb.instance(source.scene, **source.parameters)
        for count in facets:
            program = problem.qp(count) if count else problem.cone()
            G, A = program.G, program.A
            rows, bounds = sparse.vstack([G, A], format="csc"), np.concatenate([program.h, program.b])
            m, joints = G.shape[0], clarabel.ZeroConeT(A.shape[0])
            bodies = [clarabel.NonnegativeConeT(m)] if count else [clarabel.SecondOrderConeT(3)] * (m // 3)
            cones = [*bodies, joints]
            given = sparse.triu(program.P, format="csc"), program.q, rows, bounds, cones, settings
            runs = [clarabel.DefaultSolver(*given).solve() for _ in range(repeats)]
            yield {
                "number": number,  # of the problem
                "facets": count,  # of the polygon, 0 for the cone
                "solved": str(runs[0].status) == "Solved",
                "iterations": runs[0].iterations,
                "seconds": min(run.solve_time for run in runs),  # by Clarabel's own clock, the smallest of the repeats
            }


def summary(found: Tables) -> Summary:
    ball, problems = found["ball"], found["problems"]
    cone, polygons = ball[ball["facets"] == 0].iloc[0], ball[ball["facets"] > 0]
    bends = polygons.groupby("facets")["from_cone"].agg(["mean", "max"])
    slope, worst = order(bends.index, bends["mean"]), order(bends.index, bends["max"])
    errors = problems[problems["error"] > KINK].groupby(["facets", "number"])["error"].mean()
    erring = errors.groupby("facets").median()
    of_problems = order(erring.index, erring)
    two = problems[problems["solutions_apart"] > DISTINCT].groupby("number").first()
    coarse, fine = bends.index.min(), bends.index.max()
    enough = bends.index[bends["max"] < cone["from_parabola"]]
    require(slope.value < -0.5, "more facets approach the cone")
    clocks = found["interior"][found["interior"]["solved"]].pivot_table(index="number", columns="facets", values="seconds")
    inner = clocks.drop(columns=0).div(clocks[0], axis=0).median()
    numbers = {
        "coarse": coarse,
        "coarse_bend": f"{100 * bends['mean'].iloc[0]:.1f}",
        "length": f"{np.hypot(cone['x'][-1], cone['y'][-1]):.2f}",
        "fine": fine,
        "fine_bend": f"{1000 * bends['mean'].iloc[-1]:.2f}",
        "slope": slope,
        "worst": worst,
        "step_ms": f"{1000 * cone['step']:g}",
        "from_parabola": f"{1000 * cone['from_parabola']:.1f}",
        "enough": len(enough),
        "enough_from": enough.min(),
        "problems": problems["number"].nunique(),
        "first_error": f"{erring.iloc[0]:.2g}",
        "first_facets": erring.index[0],
        "last_error": f"{erring.iloc[-1]:.2g}",
        "last_facets": erring.index[-1],
        "order": of_problems,
        "inner": ", ".join(f"{ratio:.2g} with {count}" for count, ratio in inner.items()),
        "inner_least": f"{inner.min():.2g}",
        "inner_most": f"{inner.max():.2g}",
        "two": len(two),
        "two_scenes": ", ".join(sorted({*two["scene"]})),
    }
    figures = {
        "ball": (
            Panel("across the parabola, mm", partial(_paths, ball=ball)),
            Panel("distance of the paths", partial(_distances, bends=bends)),
        ),
        "problems": (
            Panel("error", partial(_errors, problems=problems)),
            Panel("time over that with the cone", partial(_ratios, clocks=clocks)),
        ),
    }
    return Summary(numbers, figures)


def _paths(ax: Axes, ball: pd.DataFrame) -> None:
    shown = ball[(ball["angle"] == 0) & ball["facets"].isin([0, 4, 6, 8, 16])]
    for k, row in enumerate(shown.to_dict("records")):
        label = f"{row['facets']} facets" if row["facets"] else "cone"
        curve(ax, k, row["x"], 1000 * np.array(row["aside"]), label, marker="")
    finish(ax, "x, m", "mm")


def _distances(ax: Axes, bends: pd.DataFrame) -> None:
    facets, first = bends.index.to_numpy(float), bends["mean"].iloc[0]
    curve(ax, 0, facets, bends["mean"], "mean over orientations")
    curve(ax, 1, facets, bends["max"], "worst orientation")
    ax.plot(facets, first * facets[0] / facets, color=INK, lw=0.6, ls=":")
    finish(ax, "facets", "m", "xy")


def _errors(ax: Axes, problems: pd.DataFrame) -> None:
    for k, (_, own) in enumerate(problems.groupby("number")):
        mean = own.groupby("facets")["error"].mean().clip(lower=KINK)
        curve(ax, k, mean.index, mean, f"{own['scene'].iloc[0]}, {own['contacts'].iloc[0]}")
    finish(ax, "facets", "error of the velocity", "xy")


def _ratios(ax: Axes, clocks: pd.DataFrame) -> None:
    ratio = clocks.drop(columns=0).div(clocks[0], axis=0)
    curve(ax, 1, ratio.columns, ratio.median(), "interior point, median")
    ax.axhline(1, color=INK, lw=0.6, ls=":")
    finish(ax, "facets", "time ratio", "xy")


STUDY = Study((ball, problems, interior), summary)
