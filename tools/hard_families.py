"""The third part of docs/performance.md: what is solved of families of hard problems, each instance with a seed of its own.

Each instance is solved once by a method and once, as its convex relaxation, by Clarabel, one after the other, by the
processor's time. An instance is solved where the residual on the exact problem is within TOL, or, in families whose rounding
does not allow that, within the rounding floor of the answer.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from statistics import median
from time import process_time

import numpy as np
from numba.core.event import install_timer

import frictionbench as fb
from frictionbench.problems import FrictionProblem
from frictionbench.solvers import Answer

TOL, LIMIT = 1e-8, 60.0  # s, of one problem
PEER = "clarabel"
HEAD = f"""## Hard families

Every instance has a seed of its own. *solved*: within {TOL:g} on the exact problem, in {LIMIT:g} s; under *worst* stands the
largest residual where one is not. *factorisations*, or *pivots* of lemke: median and most. *time*: processor's time of form,
setup and solve over that of {PEER} on the convex relaxation of the same problem, one after the other, median and longest;
*longest, s* is in seconds of the machine of this page. The relaxation is an easier problem, and where contacts slide another
one: its time is a unit. By `interior_point` where no method is named. Masses over 3e7 to 3e10 do not allow {TOL:g} everywhere;
there an answer is solved that is within its own rounding floor.
"""


@dataclass(frozen=True)
class Family:
    """Instances 0, 1, … of problems, what solves them, and whether rounding keeps them from TOL."""

    title: str
    make: Callable[[int], FrictionProblem]
    instances: int
    method: str = "interior_point"
    floored: bool = False


@dataclass(frozen=True)
class Solve:
    """One instance: contacts, residual, whether it is solved, work, and seconds of the method and of the peer."""

    contacts: int
    residual: float
    solved: bool
    work: int
    seconds: float
    peer: float


def _local_graph(k: int) -> FrictionProblem:
    """1000 to 10 000 contacts in a hundred instances."""
    return fb.instance("local_graph", seed=1000 + k, bodies=round(625 * 10 ** (k / 99)))


def _random_graph(bodies: int) -> Callable[[int], FrictionProblem]:
    return lambda k: fb.instance("random_graph", seed=k, bodies=bodies)


def _discs(k: int) -> FrictionProblem:
    return fb.scene("disc_pile", rows=6 + k // 7, friction=_uniform(k, 0.1, 0.9), push=(0.0, 0.5)[k % 2]).problem()


def _masses(ratio: float) -> Callable[[int], FrictionProblem]:
    return lambda k: fb.instance(
        "sphere_pyramid", seed=100 + k, levels=2 + k % 4, friction=_uniform(k, 0.3, 0.7), mass_ratio=ratio
    )


def _bodies(k: int) -> FrictionProblem:
    return fb.instance("random_bodies", seed=100 + k, contacts=20 + k, mass_ratio=1e8)


def _wall(points: int) -> Callable[[int], FrictionProblem]:
    def make(k: int) -> FrictionProblem:
        rows, bricks = divmod(k % 9, 3)
        return fb.instance("box_wall", seed=k, rows=3 + rows, bricks=3 + bricks, points=points, noise=(0.1, 0.5)[k % 2])

    return make


def _pyramid(k: int) -> FrictionProblem:
    return fb.instance("sphere_pyramid", seed=100 + k, levels=8, friction=_uniform(k, 0.3, 0.7), noise=(0.0, 0.01, 0.03)[k % 3])


def _heavy_stack(k: int) -> FrictionProblem:
    """2 to 4 blocks, masses over 3e7 to 3e10."""
    blocks, ratio = 2 + k % 3, 3 * 10.0 ** (7 + k // 3 % 4)
    push, friction = np.random.default_rng(k).uniform([0.2, 0.2], [2.0, 0.8])
    return fb.scene("stack", blocks=blocks, mass_ratio=ratio, push=push, friction=friction).problem()


def _uniform(seed: int, least: float, most: float) -> float:
    return float(np.random.default_rng(seed).uniform(least, most))


FAMILIES = (
    Family("local graphs in the plane", _local_graph, 100),
    Family("graphs without places, 1000 contacts", _random_graph(625), 4),
    Family("graphs without places, 2000 contacts", _random_graph(1250), 4),
    Family("graphs without places, 4000 contacts", _random_graph(2500), 4),
    Family("piles of discs, 6 to 18 rows", _discs, 91),
    Family("stacks, masses to 3e10, by lemke", _heavy_stack, 120, "lemke", floored=True),
    Family("pyramids of spheres, masses over 1e4", _masses(1e4), 36),
    Family("pyramids of spheres, masses over 1e6", _masses(1e6), 36),
    Family("random bodies, masses over 1e8", _bodies, 36),
    Family("walls of boxes, 4 contacts a face", _wall(4), 36),
    Family("walls of boxes, 8 contacts a face", _wall(8), 36),
    Family("pyramids of spheres, 8 levels", _pyramid, 30),
)


def section(families: tuple[Family, ...] = FAMILIES) -> str:
    """The section in Markdown."""
    columns = (
        "| family | contacts | solved | worst | factorisations | most | time | longest | longest, s |\n"
        + "|---"
        + "|--:" * 8
        + "|"
    )
    return "\n".join([HEAD, columns, *(_row(family) for family in families), ""])


def _row(family: Family) -> str:
    found = list(_solves(family))
    contacts, work = sorted(each.contacts for each in found), [each.work for each in found]
    ratios, solved = [each.seconds / each.peer for each in found], sum(each.solved for each in found)
    cells = (
        family.title,
        str(contacts[0]) if contacts[0] == contacts[-1] else f"{contacts[0]}–{contacts[-1]}",
        f"{solved} of {len(found)}",
        "" if solved == len(found) else f"{max(each.residual for each in found):.0e}",
        f"{median(work):.0f}",
        str(max(work)),
        f"{median(ratios):.2g}",
        f"{max(ratios):.2g}",
        f"{max(each.seconds for each in found):.2g}",
    )
    return f"| {' | '.join(cells)} |"


def _solves(family: Family) -> Iterator[Solve]:
    for k in range(family.instances):
        problem = family.make(k)
        answer, seconds = _timed(problem, family.method, LIMIT)
        found = fb.residual(problem, answer.impulse)
        enough = max(TOL, fb.residual_floor(problem, answer.impulse)) if family.floored else TOL
        work = answer.work.get("factorisations", 0) or answer.work.get("pivots", 0)
        yield Solve(problem.contacts, found, found <= enough, work, seconds, _timed(problem, PEER, None)[1])


def _timed(problem: FrictionProblem, method: str, limit: float | None) -> tuple[Answer, float]:
    """The answer and its time; solved again where kernels that few instances need were compiled or loaded meanwhile."""
    while True:
        compiled: list[float] = []
        given = problem.fresh()
        with install_timer("numba:compiler_lock", compiled.append):
            begun = process_time()
            answer = fb.solve(given, method, tol=TOL, time_limit=limit)
            seconds = process_time() - begun
        if not compiled:
            return answer, seconds
