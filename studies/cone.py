"""The Coulomb cone itself or a polygon: error and time against the number of facets."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product
from time import thread_time

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.harness.plans.plan import Source
from frictionbench.problems import FrictionProblem, simulation
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK
from frictionbench.solvers import solve
from studies.motions import apart
from studies.study import Array, Row, Study, Summary, Tables, curve, finish, order, require

KINK = 1e-9  # errors below it are rounding
DISTINCT = 1e-4  # solutions further apart count as two
CONE, TOL = "interior_point", 1e-10
SLIDING = 0.236  # s, until the ball rolls
FACETS = (4, 6, 8, 12, 16, 24, 32, 64)
LIMIT = 60  # iterations of the interior point method
BALL_TURNS, TURNS = 40, 8  # orientations of each polygon, evenly over the angle of a facet: of the ball, of problems
SPACE = (
    Source("cubes", {"boxes": 2, "friction": 0.2, "push": 0.5, "twist": 2.0, "fall": 1.0}),
    Source("sphere_pyramid", {"levels": 2, "friction": 0.1, "noise": 0.3}),
    Source("random_bodies", {"contacts": 8, "seed": 1}),
    Source("random_bodies", {"contacts": 20}),
    Source("rod_chain", {"links": 4}),
    Source("packed_spheres", {"spheres": 15, "noise": 1.0}),
)


def turned(problem: FrictionProblem, angle: float, spec: str, tol: float) -> Array:
    """Return the impulses (nc, 3) by a solver whose polygon has its first corner at this angle from the first tangent."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    rows = problem.tangent.toarray().reshape(problem.contacts, 2, -1)
    frame = problem.replace(tangent=np.einsum("ab,ibv->iav", turn, rows).reshape(2 * problem.contacts, -1))
    r = solve(frame, spec, tol=tol).impulse
    return np.column_stack([r[:, :1], r[:, 1:] @ turn])


def orientations(facets: int, turns: int) -> Array:
    """Return angles of a polygon's first corner, evenly spaced over the angle of a facet; one for the cone."""
    return 2 * np.pi / facets * np.arange(turns) / turns if facets else np.zeros(1)


def ball(facets: Iterable[int] = (0, *FACETS), step: float = 0.004, turns: int = BALL_TURNS) -> Iterator[Row]:
    """A sliding ball with side spin: the distances of its path from the parabola and from the path with the cone (0 facets)."""
    stage = fb.scene("sliding_ball", step=step, duration=SLIDING)
    assert stage.path is not None
    parabola = np.vstack([stage.path(k * step) for k in range(stage.steps + 1)])

    def path(spec: str, angle: float = 0.0) -> Array:
        answer = partial(turned, angle=angle, spec=spec, tol=1e-9)
        return np.vstack([stage.geometry.centres(now.q) for now in simulation(stage, answer)])

    cone = path(CONE)
    for count, angle in ((polygon, turn) for polygon in facets for turn in orientations(polygon, turns)):
        found = path(f"lemke[facets={count}]", angle) if count else cone
        yield {
            "facets": count,  # of the polygon, 0 for the cone
            "angle": angle,  # of the polygon's first corner, rad
            "step": step,  # s
            # largest distance of the path from the parabola, m
            "from_parabola": float(np.linalg.norm(found - parabola, axis=1).max()),
            # largest distance of the path from that with the cone, m
            "from_cone": float(np.linalg.norm(found - cone, axis=1).max()),
            "length": float(np.linalg.norm(found[-1] - found[0])),  # between the ends of the path, m
        }


def problems(facets: Iterable[int] = FACETS[:-1], sources: Iterable[Source] = SPACE, turns: int = TURNS) -> Iterator[Row]:
    """Spatial problems by the cone and by polygons: the velocities' error.

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
                # |v - v_cone|_M / |v*|_M to the nearer of the known solutions with the cone
                "error": min(apart(problem, v, known) for known in velocities),
                # the same between these: above 0 there are two
                "solutions_apart": apart(problem, velocities[0], velocities[-1]),
            }


def interior(facets: Iterable[int] = (0, *FACETS), sources: Iterable[Source] = SPACE, repeats: int = 7) -> Iterator[Row]:
    """Coulomb's law on the same problems with the cone, 0 facets, and with polygons by one interior point method."""
    for (number, source), count in product(enumerate(sources), facets):
        problem, times = fb.instance(source.scene, **source.parameters), []
        for _ in range(repeats):
            begun = thread_time()
            impulse, iterations = predictor_corrector(problem, count)
            times.append(thread_time() - begun)
        yield {
            "number": number,  # of the problem
            "facets": count,  # of the polygon, 0 for the cone
            "solved": iterations < LIMIT,
            "iterations": iterations,
            "seconds": min(times),  # of the processor, the smallest of the repeats
            "residual": fb.residual(problem, impulse),  # of Coulomb's law with the cone
        }


def predictor_corrector(problem: FrictionProblem, facets: int, tol: float = 1e-8) -> tuple[Array, int]:
    """Mehrotra's method on Coulomb's law, mu > 0, with the cone or a polygon. Return impulses and iterations, LIMIT on failure.

    At each contact r_n >= 0, u_n >= 0 and r_n u_n = 0. With k generators A_i of friction, (mu r_n, r_t) = sum A_i'x_i and
    y_i = A_i (lambda, u_t) with x_i o y_i = 0. For a polygon A_i = (1, d_i) and x_i, y_i >= 0, which is its LCP with the slack
    mu r_n - sum x_i at 0. For the cone A = I, x and y are in the second-order cone, and o is its Jordan product, linearised
    without scaling. Only the velocities and the joints' impulses are not eliminated contact by contact. tol: for the mean of
    the products, SI units; the equations are satisfied to a hundred times that, because of rounding.
    """
    nc, (nj, nv), mu = problem.contacts, problem.joints.shape, problem.friction[:, None]
    angle = 2 * np.pi / max(facets, 1) * np.arange(facets)
    fan = np.stack([np.ones(facets), np.cos(angle), np.sin(angle)], axis=1)[:, None] if facets else np.eye(3)[None]
    J = np.concatenate([problem.normal.toarray()[:, None], problem.tangent.toarray().reshape(nc, 2, nv)], axis=1)
    M, F, bias = problem.mass.toarray(), problem.joints.toarray(), problem.bias[:, None] * [1, 0, 0]
    v, joint, u = problem.free_velocity, np.zeros(nj), J @ problem.free_velocity + bias
    opening = np.full((nc, 1), np.abs(u).max())
    y = np.einsum("kpa,na->nkp", fan, np.column_stack([np.linalg.norm(u[:, 1:], axis=1) + opening[:, 0], u[:, 1:]]))
    x = np.zeros_like(y)
    x[..., 0] = mu * opening / problem.scale.max() / len(fan)
    for done in range(LIMIT):
        r, u = np.einsum("kpa,nkp->na", fan, x), J @ v + bias
        r[:, :1] /= mu
        c = r[:, :1]
        momentum, gap = M @ (v - problem.free_velocity) - np.einsum("nav,na", J, r) - F.T @ joint, opening - u[:, :1]
        drift = F @ v + problem.joint_bias
        mean = ((c * opening).sum() + (x * y).sum()) / (nc + nc * len(fan))
        if max(mean, *(0.01 * np.abs(each).max(initial=0.0) for each in (momentum, gap, drift))) < tol:
            return r, done
        theta = np.einsum("kpa,nkbp->nab", fan, _divided(_times(x[..., None, :], fan.swapaxes(1, 2)), y[..., None, :]))
        top = np.column_stack([mu * c / opening, -theta[:, 0, 1:]]) / theta[:, 0, :1]  # d lambda = shift + top du
        H = theta[:, :, :1] * top[:, None]  # dr = right - H du
        H[:, 1:, 1:] += theta[:, 1:, 1:]
        H[:, 0] = c / opening * [1, 0, 0]
        newton = np.block([[M + np.einsum("nav,nab,nbw->vw", J, H, J), -F.T], [F, np.zeros((nj, nj))]])
        inverse, aim, aims = np.linalg.inv(newton), -c * opening, -_times(x, y)
        for corrects in (False, True):
            held = np.einsum("kpa,nkp->na", fan, _divided(aims, y))
            normal = (aim + c * gap) / opening
            shift = (held[:, :1] - mu * normal) / theta[:, 0, :1]
            right = np.column_stack([normal, held[:, 1:] - theta[:, 1:, 0] * shift])
            known = np.concatenate([np.einsum("nav,na", J, right) - momentum, -drift])
            dv, djoint = np.split(inverse @ known, [nv])
            du = J @ dv
            dc, dopening = normal - c / opening * du[:, :1], du[:, :1] - gap
            dy = np.einsum("kpa,na->nkp", fan, np.column_stack([shift[:, 0] + (top * du).sum(axis=1), du[:, 1:]]))
            dx = _divided(aims - _times(x, dy), y)
            t = 1 / max(1, *(_shrinkage(*pair) for pair in ((x, dx), (y, dy), (c, dc), (opening, dopening))))
            if not corrects:
                after = ((c + t * dc) * (opening + t * dopening)).sum() + ((x + t * dx) * (y + t * dy)).sum()
                centre = (after / (nc + nc * len(fan))) ** 3 / mean**2
                aim, aims = aim - dc * dopening + centre, aims - _times(dx, dy)
                aims[..., 0] += centre
        v, joint, opening, x, y = v + t * dv, joint + t * djoint, opening + t * dopening, x + t * dx, y + t * dy
    return r, LIMIT


def _times(x: Array, y: Array) -> Array:
    """Return the Jordan product of second-order cones in the last axis, or the product of numbers if it has one entry."""
    x, y = np.broadcast_arrays(x, y)
    return np.concatenate([(x * y).sum(-1, keepdims=True), x[..., :1] * y[..., 1:] + y[..., :1] * x[..., 1:]], axis=-1)


def _divided(z: Array, y: Array) -> Array:
    """Return x with x o y = z."""
    first = y[..., :1] * z[..., :1] - (y[..., 1:] * z[..., 1:]).sum(-1, keepdims=True)
    first = first / (y[..., :1] ** 2 - (y[..., 1:] ** 2).sum(-1, keepdims=True))
    return np.concatenate([first, (z[..., 1:] - y[..., 1:] * first) / y[..., :1]], axis=-1)


def _shrinkage(x: Array, dx: Array) -> float:
    """Return 1/t for the t with which x + t dx goes 0.995 of the way to the boundary of the cones."""
    size = np.sqrt(x[..., :1] ** 2 - (x[..., 1:] ** 2).sum(-1, keepdims=True))
    along = (x[..., :1] * dx[..., :1] - (x[..., 1:] * dx[..., 1:]).sum(-1, keepdims=True)) / size
    rest = dx[..., 1:] - (along + dx[..., :1]) / (x[..., :1] + size) * x[..., 1:]
    return float(((np.linalg.norm(rest, axis=-1, keepdims=True) - along) / size).max() / 0.995)


def summary(tables: Tables) -> Summary:
    ball, problems = tables["ball"], tables["problems"]
    cone, polygons = ball[ball["facets"] == 0].iloc[0], ball[ball["facets"] > 0]
    bends, off = (polygons.groupby("facets")[of].agg(["mean", "min", "max"]) for of in ("from_cone", "from_parabola"))
    slope = order(bends.index, bends["mean"])
    errors = problems[problems["error"] > KINK].groupby(["facets", "number"])["error"].agg(["mean", "min", "max"])
    erring, spread = errors["mean"].groupby("facets").median(), errors[["min", "max"]].div(errors["mean"], axis=0)
    two = problems[problems["solutions_apart"] > DISTINCT].groupby("number").first()
    coarse, fine = bends.index.min(), bends.index.max()
    enough = bends.index[bends["max"] < cone["from_parabola"]]
    require(slope.value < -0.5, "more facets approach the cone")
    interior = tables["interior"]
    require(interior["solved"].all(), "the interior point method solves all problems")
    require((interior[interior["facets"] == 0]["residual"] < 1e-5).all(), "with the cone it solves Coulomb's law")
    pivot = interior.pivot_table(index="number", columns="facets", values=["iterations", "seconds"])
    counts, clocks = (pivot[name].drop(columns=0).div(pivot[name][0], axis=0) for name in ("iterations", "seconds"))
    inner, rounds = clocks.median(), counts.median()
    numbers = {
        "coarse": coarse,
        "coarse_bend": _spread(bends.iloc[0]),
        "coarse_off": _spread(off.iloc[0]),
        "length": f"{cone['length']:.2f}",
        "fine": fine,
        "fine_bend": _spread(bends.iloc[-1]),
        "fine_off": _spread(off.iloc[-1]),
        "bends": [(count, _spread(at)) for count, at in bends.iterrows()],
        "turns": len(polygons) // len(bends),
        "spread": f"{spread['min'].min():.2g} to {spread['max'].max():.2g}",
        "usual": f"{spread['min'].median():.2g} to {spread['max'].median():.2g}",
        "slope": slope,
        "step_ms": f"{1000 * cone['step']:g}",
        "from_parabola": f"{1000 * cone['from_parabola']:.1f}",
        "enough": len(enough),
        "enough_from": enough.min(),
        "problems": problems["number"].nunique(),
        "sizes": f"{problems['contacts'].min()} to {problems['contacts'].max()}",
        "first_error": f"{erring.iloc[0]:.2g}",
        "first_facets": erring.index[0],
        "last_error": f"{erring.iloc[-1]:.2g}",
        "last_facets": erring.index[-1],
        "order": order(erring.index, erring),
        "inner": ", ".join(f"{ratio:.2g} with {count}" for count, ratio in inner.items()),
        "inner_least": f"{inner.min():.2g}",
        "inner_most": f"{inner.max():.2g}",
        "rounds": ", ".join(f"{ratio:.2g} with {count}" for count, ratio in rounds.items()),
        "cone_rounds": f"{pivot['iterations'][0].min():.0f} to {pivot['iterations'][0].max():.0f}",
        "inner_pairs": clocks.size,
        "inner_dearer": int((clocks > 1).to_numpy().sum()),
        "two": len(two),
        "two_scenes": ", ".join(sorted({*two["scene"]})),
    }
    figures = {
        "ball": (Panel("distance of the paths", partial(_distances, bends=bends)),),
        "problems": (
            Panel("error", partial(_errors, problems=problems)),
            Panel("time over that with the cone", partial(_ratios, clocks=clocks)),
        ),
    }
    return Summary(numbers, figures)


def _spread(at: pd.Series) -> str:
    """Format the mean over orientations, with the least and the largest value, in mm."""
    return "{:.2g} ({:.2g} to {:.2g})".format(*1000 * at)


def _distances(ax: Axes, bends: pd.DataFrame) -> None:
    facets, first = bends.index.to_numpy(float), bends["mean"].iloc[0]
    for k, (of, label) in enumerate({"mean": "mean over orientations", "min": "least", "max": "largest"}.items()):
        curve(ax, k, facets, bends[of], label)
    ax.plot(facets, first * facets[0] / facets, color=INK, lw=0.6, ls=":")
    finish(ax, "facets", "m", "xy")


def _errors(ax: Axes, problems: pd.DataFrame) -> None:
    for k, (_, group) in enumerate(problems.groupby("number")):
        mean = group.groupby("facets")["error"].mean().clip(lower=KINK)
        curve(ax, k, mean.index, mean, f"{group['scene'].iloc[0]}, {group['contacts'].iloc[0]}")
    finish(ax, "facets", "error of the velocity", "xy")


def _ratios(ax: Axes, clocks: pd.DataFrame) -> None:
    for k, (_, ratios) in enumerate(clocks.iterrows()):
        curve(ax, k, ratios.index, ratios)
    ax.axhline(1, color=INK, lw=0.6, ls=":")
    finish(ax, "facets", "time ratio", "xy")


STUDY = Study((ball, problems, interior), summary)
