"""Our solvers beside those a user would pick instead: time, and residual recomputed, in the plane and in space.

    PYTHONPATH=. python tests/benchmarks/peers.py [--repeat 5] [--planar 8,40,80,200,400] [--spatial 4,20,40,100,200]

prints Markdown, which docs/peers.md explains. In the plane a size is that of the friction LCP, four unknowns a contact; its
instances are a stack and the pyramid nearest in size, with mu = .05, .2 and .8, resting and pushed. In space a size is the
number of contacts, with the circular cone; its instances are the same six stacks, of cubes, and six random problems. Every
solver meets every instance once a round, one after the other, so that drift of the machine hits all alike. An instance's time
is the median over the rounds, a size's the median over its instances; an instance that is not solved counts as infinitely
slow. A solve longer than SLOW is not asked for again. Solvers that are not installed are skipped with the reason.
"""

# ruff: noqa: E402
from harness.machine import pin_threads

pin_threads()  # before the libraries start theirs

import argparse
import sys
import tempfile
import warnings
from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np
from peer_solvers import SOLVED, Prepare, planar_makers, spatial_makers

from problems import FrictionProblem, scene
from problems.instances.cubes import cubes
from problems.instances.random_bodies import random_bodies
from problems.residual import relaxation_residual, residual

SLOW = 0.1  # s

Makers = Callable[[dict[int, int], str], dict[str, Callable[[], Prepare]]]


class Figures(NamedTuple):
    """Over a size's instances: median ms to solve and to prepare; how many are solved exactly, and as the relaxation."""

    solve: float
    prepare: float
    exact: int
    relaxed: int


def planar(n: int) -> list[FrictionProblem]:
    """The twelve problems of about n unknowns: eight a box, in a stack or a pyramid."""
    rows = min(range(1, 100), key=lambda rows: abs(4 * rows * (rows + 1) - n))
    shapes: list[tuple[str, dict[str, int]]] = [("stack", {"blocks": n // 8}), ("pyramid", {"rows": rows})]
    return [
        scene(name, friction=mu, push=push, **size).problem()
        for name, size in shapes
        for mu in (0.05, 0.2, 0.8)
        for push in (0.0, 1.0)
    ]


def spatial(contacts: int) -> list[FrictionProblem]:
    """The twelve problems with so many spatial contacts: stacks of cubes, and random ones between half as many bodies."""
    pushes = [(mu, push) for mu in (0.05, 0.2, 0.8) for push in (0.0, 1.0)]
    stacks = [cubes(contacts // 4, friction=mu, push=push) for mu, push in pushes]
    return stacks + [random_bodies(seed, contacts, mu) for mu in (0.1, 0.5, 1.0) for seed in (0, 1)]


def write(problems: list[FrictionProblem], file: str) -> None:
    """The problems for a child process: W{k}, q{k}, mu{k}, and in the plane the LCP's M{k}, b{k}."""
    arrays = {}
    for k, problem in enumerate(problems):
        arrays |= {f"W{k}": problem.W.toarray(), f"q{k}": problem.q, f"mu{k}": problem.friction}
        if problem.dimension == 2:
            arrays |= {f"M{k}": problem.lcp().dense, f"b{k}": problem.lcp().q}
    np.savez(file, **arrays)


def present(problems: list[FrictionProblem], makers: Makers, file: str) -> tuple[dict[str, Prepare], dict[str, str]]:
    """The solvers that run here, and why the others do not."""
    here, skipped = {}, {}
    for name, make in makers({id(problem): k for k, problem in enumerate(problems)}, file).items():
        try:
            here[name] = make()
        except Exception as reason:  # a missing library or licence fails in its own way
            skipped[name] = f"{type(reason).__name__}: {reason}"
    return here, skipped


def measure(
    problems: list[FrictionProblem], makers: Makers, repeat: int, file: str
) -> tuple[dict[str, Figures], dict[str, str]]:
    """Every solver's figures on these problems, and the reasons of those skipped."""
    write(problems, file)
    prepares, skipped = present(problems, makers, file)
    solve, prepare = np.full((2, len(prepares), len(problems), repeat), np.nan)
    exact, relaxed = np.zeros((2, len(prepares), len(problems)), dtype=bool)
    for k, problem in enumerate(problems):
        solves = {name: make(problem) for name, make in prepares.items()}
        if k == 0:
            for each in solves.values():  # compile, load, allocate
                each()
        for turn in range(repeat):
            for row, (name, make) in enumerate(prepares.items()):
                if turn and np.nanmax(solve[row, k]) > SLOW:
                    continue
                solve[row, k, turn], impulse = solves[name]()
                exact[row, k] = residual(problem, impulse) <= SOLVED
                relaxed[row, k] = relaxation_residual(problem, impulse) <= SOLVED
                if not name.startswith(("PATH", "Siconos")):  # theirs is QuantEcon's, and reading a file
                    fresh, start = problem.fresh(), perf_counter()
                    make(fresh)
                    prepare[row, k, turn] = perf_counter() - start
    figures = {}
    for row, name in enumerate(prepares):
        reached = relaxed[row] if name.startswith("relaxation") else exact[row]
        each_solve = np.where(reached, np.nanmedian(solve[row], axis=1), np.inf)
        to_prepare = np.nanmedian(prepare[row]) if np.isfinite(prepare[row]).any() else np.nan
        medians = 1e3 * np.array([np.median(each_solve), to_prepare])
        figures[name] = Figures(*medians.tolist(), int(exact[row].sum()), int(relaxed[row].sum()))
    return figures, skipped


def table(head: str, sizes: list[str], rows: dict[str, list[str]]) -> str:
    lines = [
        [head, *sizes],
        ["---"] + ["--:"] * len(sizes),
        *([name, *row] for name, row in rows.items()),
    ]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def number(x: float) -> str:
    """Two digits, and a dash for what is not finite."""
    return "–" if not np.isfinite(x) else f"{x:.2g}" if x < 10 else f"{x:.0f}"


def compare(name: str, sizes: list[int], family: Callable[[int], list[FrictionProblem]], makers: Makers, repeat: int) -> None:
    """Measure one family over its sizes and print its tables."""
    results, skipped = [], {}
    with tempfile.TemporaryDirectory() as folder:
        for size in sizes:
            figures, reasons = measure(family(size), makers, repeat, f"{folder}/problems-{size}.npz")
            results.append(figures)
            skipped |= reasons
            print(f"{name} = {size} measured", file=sys.stderr)
    times, solved, prepared = {}, {}, {}
    for solver in [solver for solver in results[0] if all(solver in figures for figures in results)]:
        rows = [figures[solver] for figures in results]
        times[solver] = [
            f"{number(row.solve)} ({number(row.solve / figures['hybrid'].solve)})"
            for row, figures in zip(rows, results, strict=True)
        ]
        solved[solver] = [f"{row.exact}, {row.relaxed}" if solver.startswith("relaxation") else str(row.exact) for row in rows]
        if np.isfinite(rows[0].prepare):
            prepared[solver] = [number(row.prepare) for row in rows]
    columns = [f"{name} = {size}" for size in sizes]
    print(table("solve, ms (over hybrid's)", columns, times))
    print(table(f"of 12 solved to {SOLVED:g} (a relaxation: exactly, as such)", columns, solved))
    print(table("prepare, ms", columns, prepared))
    print("\n".join(f"skipped: {solver}: {reason}" for solver, reason in skipped.items()))


def main() -> None:
    arguments = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    arguments.add_argument("--planar", default="8,40,80,200,400")
    arguments.add_argument("--spatial", default="4,20,40,100,200")
    arguments.add_argument("--repeat", type=int, default=5)
    given = arguments.parse_args()
    warnings.simplefilter("ignore")  # qpsolvers' word on a failure
    families = (("n", given.planar, planar, planar_makers), ("contacts", given.spatial, spatial, spatial_makers))
    for name, sizes, family, makers in families:
        if sizes:
            compare(name, [int(size) for size in sizes.split(",")], family, makers, given.repeat)


if __name__ == "__main__":
    main()
