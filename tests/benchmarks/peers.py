"""Our solvers beside those a user would pick instead: time, and residual recomputed, on stacks and pyramids of boxes.

    python tests/benchmarks/peers.py [--sizes 8,40,80,200,400] [--repeat 5]      prints Markdown; docs/peers.md explains it

A size n is that of the friction LCP, four unknowns a contact; its instances are a stack and the pyramid nearest in size, with
mu = .05, .2 and .8, resting and pushed. Every solver meets every instance once a round, one after the other, so that drift of
the machine hits all alike. An instance's time is the median over the rounds, a size's the median over its instances; an
instance that is not solved counts as infinitely slow. A solve longer than SLOW is not asked for again. Solvers that are not
installed are skipped with the reason.
"""

# ruff: noqa: E402
from harness.machine import pin_threads

pin_threads()  # before the libraries start theirs

import argparse
import sys
import tempfile
import warnings
from time import perf_counter
from typing import NamedTuple

import numpy as np
from peer_solvers import SOLVED, Prepare, makers

from problems import FrictionProblem, scene
from problems.residual import relaxation_residual, residual

SLOW = 0.1  # s


class Figures(NamedTuple):
    """Over a size's instances: median ms to solve and to prepare; how many are solved exactly, and as the relaxation."""

    solve: float
    prepare: float
    exact: int
    relaxed: int


def instances(n: int) -> list[FrictionProblem]:
    """The twelve problems of about n unknowns: eight a box, in a stack or a pyramid."""
    rows = min(range(1, 100), key=lambda rows: abs(4 * rows * (rows + 1) - n))
    shapes: list[tuple[str, dict[str, int]]] = [("stack", {"blocks": n // 8}), ("pyramid", {"rows": rows})]
    return [
        scene(name, friction=mu, push=push, **size).problem()
        for name, size in shapes
        for mu in (0.05, 0.2, 0.8)
        for push in (0.0, 1.0)
    ]


def write(problems: list[FrictionProblem], file: str) -> None:
    """The problems for a child process: W{k}, q{k}, mu{k} and the LCP's M{k}, b{k}."""
    arrays = {}
    for k, problem in enumerate(problems):
        lcp = problem.lcp()
        arrays |= {
            f"W{k}": problem.W.toarray(),
            f"q{k}": problem.q,
            f"mu{k}": problem.friction,
            f"M{k}": lcp.dense,
            f"b{k}": lcp.q,
        }
    np.savez(file, **arrays)


def present(problems: list[FrictionProblem], file: str) -> tuple[dict[str, Prepare], dict[str, str]]:
    """The solvers that run here, and why the others do not."""
    here, skipped = {}, {}
    for name, make in makers({id(problem): k for k, problem in enumerate(problems)}, file).items():
        try:
            here[name] = make()
        except Exception as reason:  # a missing library or licence fails in its own way
            skipped[name] = f"{type(reason).__name__}: {reason}"
    return here, skipped


def measure(n: int, repeat: int, file: str) -> tuple[dict[str, Figures], dict[str, str]]:
    """Every solver's figures at size n, and the reasons of those skipped."""
    problems = instances(n)
    write(problems, file)
    prepares, skipped = present(problems, file)
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


def table(head: str, sizes: list[int], rows: dict[str, list[str]]) -> str:
    lines = [
        [head, *(f"n = {n}" for n in sizes)],
        ["---"] + ["--:"] * len(sizes),
        *([name, *row] for name, row in rows.items()),
    ]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def number(x: float) -> str:
    """Two digits, and a dash for what is not finite."""
    return "–" if not np.isfinite(x) else f"{x:.2g}" if x < 10 else f"{x:.0f}"


def main() -> None:
    arguments = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    arguments.add_argument("--sizes", default="8,40,80,200,400")
    arguments.add_argument("--repeat", type=int, default=5)
    given = arguments.parse_args()
    sizes = [int(n) for n in given.sizes.split(",")]
    warnings.simplefilter("ignore")  # qpsolvers' word on a failure
    results, skipped = [], {}
    with tempfile.TemporaryDirectory() as folder:
        for n in sizes:
            figures, reasons = measure(n, given.repeat, f"{folder}/problems-{n}.npz")
            results.append(figures)
            skipped |= reasons
            print(f"n = {n} measured", file=sys.stderr)
    times, solved, prepared = {}, {}, {}
    for name in [name for name in results[0] if all(name in figures for figures in results)]:
        rows = [figures[name] for figures in results]
        times[name] = [
            f"{number(row.solve)} ({number(row.solve / figures['hybrid'].solve)})"
            for row, figures in zip(rows, results, strict=True)
        ]
        solved[name] = [f"{row.exact}, {row.relaxed}" if name.startswith("relaxation") else str(row.exact) for row in rows]
        if np.isfinite(rows[0].prepare):
            prepared[name] = [number(row.prepare) for row in rows]
    print(table("solve, ms (over hybrid's)", sizes, times))
    print(table(f"of 12 solved to {SOLVED:g} (a relaxation: exactly, as such)", sizes, solved))
    print(table("prepare, ms", sizes, prepared))
    print("\n".join(f"skipped: {name}: {reason}" for name, reason in skipped.items()))


if __name__ == "__main__":
    main()
