"""Our solvers beside those a user would pick instead: time, and residual recomputed, on stacks and pyramids of boxes.

    python tests/benchmarks/peers.py [--sizes 8,40,80,200,400] [--repeat 5]      prints Markdown; docs/peers.md explains it

A size n is that of the friction LCP, four unknowns a contact; its instances are a stack and the pyramid nearest in size, with
mu = .05, .2 and .8, resting and pushed. Every solver meets every instance once a round, one after the other, so that drift of
the machine hits all alike. A visit repeats a solve for 2 ms and keeps the least time; an instance's time is the median over the
rounds, a size's the median over its instances. An instance that is not solved counts as infinitely slow. What is not installed
is skipped with the reason. A solve longer than SLOW is not asked for again.
"""

# ruff: noqa: E402
from harness.machine import pin_threads

pin_threads()  # before the libraries start theirs

import argparse
import io
import json
import re
import select
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from problems import FrictionProblem, scene
from problems.check import Array
from problems.residual import relaxation_residual, residual
from solvers import find
from solvers.scaled_program import gap_tolerance, scaled_program

TOLERANCE, SOLVED = 1e-9, 1e-8  # asked of a solver, and what counts: that of the residual, whatever the solver claims
BUDGET, SLOW, LIMIT = 2e-3, 0.1, 5.0  # s: to repeat a solve in a visit; not to be asked again; killed, where that can be done
SICONOS_PYTHON = "/usr/bin/python3"

Solve = Callable[[], tuple[float, Array]]  # seconds, impulses (nc, d)
Prepare = Callable[[FrictionProblem], Solve]


def clocked(call: Callable[[], Any], impulse: Callable[[Any], Array]) -> Solve:
    """Least seconds of the call alone, over BUDGET; turning its result into impulses is not timed."""

    def solve() -> tuple[float, Array]:
        best, end = np.inf, perf_counter() + BUDGET
        while True:
            start = perf_counter()
            result = call()
            now = perf_counter()
            best = min(best, now - start)
            if now >= end:
                return best, impulse(result)

    return solve


def ours(spec: str) -> Prepare:
    """A solver of this repository; prepare is timed apart."""
    _, solver = find(spec)

    def prepare(problem: FrictionProblem) -> Solve:
        prepared = solver.prepare(problem)
        return clocked(lambda: solver.solve(prepared, SOLVED, None), lambda answer: answer.impulse)

    return prepare


def quantecon(**options: float) -> Prepare:
    """QuantEcon's lcp_lemke (numba, dense tableau): around the call; M dense and q are prepared."""
    from quantecon.optimize import PivOptions
    from quantecon.optimize.lcp_lemke import lcp_lemke

    pivoting = PivOptions(**options)

    def prepare(problem: FrictionProblem) -> Solve:
        lcp = problem.lcp()
        M, q = lcp.dense.copy(), lcp.q.copy()
        limit = 100 * len(q) + 1000
        call = (lambda: lcp_lemke(M, q, None, limit, pivoting)) if options else (lambda: lcp_lemke(M, q, None, limit))
        return clocked(call, lambda result: lcp.impulse(result.z))

    return prepare


def path() -> Prepare:
    """PATH through GAMSPy: the total time of PATH's own log, of three solves from z = 0; GAMS around it is left out."""
    import gamspy as gp

    gp.set_options({"ALLOW_AMBIGUOUS_EQUATIONS": "yes"})  # type: ignore[dict-item]
    names = ("crash_iterations", "major_iterations", "minor_iterations", "initial_point_statistics", "final_point_statistics")
    options = {f"output_{name}": "no" for name in names} | {"convergence_tolerance": TOLERANCE}

    def prepare(problem: FrictionProblem) -> Solve:
        lcp, m = problem.lcp(), gp.Container()
        i = gp.Set(m, "i", records=[str(k) for k in range(lcp.size)])
        j = gp.Alias(m, "j", alias_with=i)
        M, q = gp.Parameter(m, "M", domain=[i, j], records=lcp.dense), gp.Parameter(m, "q", domain=[i], records=lcp.q)
        z, w = gp.Variable(m, "z", type="positive", domain=[i]), gp.Equation(m, "w", domain=[i])
        w[i] = gp.Sum(j, M[i, j] * z[j]) + q[i] >= 0
        model = gp.Model(m, "lcp", problem="MCP", matches={w: z})

        def solve() -> tuple[float, Array]:
            best = np.inf
            for _ in range(3):
                z.l[i] = 0
                log = io.StringIO()
                model.solve(solver="path", solver_options=options, output=log, options=gp.Options(solve_link_type="memory"))
                total = re.search(r"Total Time[. ]*([\d.]+)", log.getvalue())
                best = min(best, float(total[1]) if total else np.inf)
            return best, lcp.impulse(z.records["level"].to_numpy())

        return solve

    prepare(scene("stack", blocks=1).problem())()  # fails here and now where the demonstration licence has expired
    return prepare


def siconos(solver: str, table: dict[int, int], problems: str) -> Prepare:
    """Siconos in a child process, timed there around the driver; killed after LIMIT."""

    def start() -> subprocess.Popen[str]:
        command = [SICONOS_PYTHON, str(Path(__file__).with_name("siconos_child.py")), problems, solver]
        return subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, bufsize=1
        )

    child = [start()]

    def prepare(problem: FrictionProblem) -> Solve:
        lcp = problem.lcp()

        def solve() -> tuple[float, Array]:
            assert child[0].stdin
            assert child[0].stdout
            child[0].stdin.write(f"{table[id(problem)]}\n")
            reply = child[0].stdout.readline() if select.select([child[0].stdout], [], [], LIMIT)[0] else ""
            if not reply:
                child[0].kill()
                child[0].wait()
                child[0] = start()
                return np.inf, np.zeros((problem.contacts, 2))
            seconds, answer = json.loads(reply)
            if solver.startswith("LCP"):
                return seconds, lcp.impulse(np.array(answer))
            return seconds, np.array(answer).reshape(problem.contacts, -1)[:, :2]

        return solve

    return prepare


def relaxation(backend: str, dense: bool, **settings: Any) -> Prepare:
    """The convex relaxation, scaled as by our ccp, through qpsolvers, whose 40 us or so a call are part of the time."""
    import qpsolvers

    if backend not in qpsolvers.available_solvers:
        raise ImportError(f"{backend} not installed")

    def prepare(problem: FrictionProblem) -> Solve:
        scaled = scaled_program(problem, problem.qp())
        P, G = (scaled.P.toarray(), scaled.G.toarray()) if dense else (scaled.P, scaled.G)
        program = qpsolvers.Problem(P, scaled.q, G, scaled.h)
        return clocked(
            lambda: qpsolvers.solve_problem(program, backend, **settings),
            lambda found: np.full((problem.contacts, 2), np.nan) if found.z is None else scaled.impulse(found.z),
        )

    return prepare


GAP = gap_tolerance(SOLVED, round_cones=False)
OURS = ("hybrid", "lemke", "path_search", "interior_point", "nsgs")
SICONOS = {
    "LCP_LEMKE": "Siconos LCP LEMKE",
    "FRICTION_2D_NSGS": "Siconos 2-D NSGS",
    "FRICTION_3D_PROX": "Siconos 3-D PROX",
    "FRICTION_3D_ADMM": "Siconos 3-D ADMM",
}
RELAXATION: dict[str, Callable[[], Prepare]] = {
    "proxqp": lambda: ours("ccp[backend=proxqp]"),
    "clarabel": lambda: ours("ccp[backend=clarabel]"),
    "osqp": lambda: ours("ccp[backend=osqp]"),
    "piqp": lambda: relaxation("piqp", False, eps_abs=SOLVED, eps_rel=0.0, eps_duality_gap_abs=GAP, eps_duality_gap_rel=0.0),
    "daqp": lambda: relaxation("daqp", True, primal_tol=TOLERANCE, dual_tol=TOLERANCE),
    "quadprog": lambda: relaxation("quadprog", True),
    "our interior point (relaxation_ip)": lambda: ours("relaxation_ip"),
}


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


def peers(problems: list[FrictionProblem], file: str) -> Iterator[tuple[str, Prepare | str]]:
    """Every solver by its name in the table, or the reason why it is skipped."""
    table = {id(problem): k for k, problem in enumerate(problems)}
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
    makers: dict[str, Callable[[], Prepare]] = {name: lambda name=name: ours(name) for name in OURS}  # type: ignore[misc]
    makers |= {"QuantEcon lcp_lemke": quantecon, "QuantEcon, tol_ratio_diff 1e-10": lambda: quantecon(tol_ratio_diff=1e-10)}
    makers["PATH 5.2 (GAMSPy)"] = path
    has_siconos = subprocess.run([SICONOS_PYTHON, "-c", "import siconos.numerics"], capture_output=True, check=False)
    for kind, name in SICONOS.items():
        makers[name] = lambda kind=kind: siconos(kind, table, file)  # type: ignore[misc]
    makers |= {f"relaxation: {name}": make for name, make in RELAXATION.items()}
    for name, make in makers.items():
        try:
            if name.startswith("Siconos") and has_siconos.returncode:
                raise ImportError(f"python3-siconos not installed for {SICONOS_PYTHON}")
            yield name, make()
        except Exception as reason:  # a missing library or licence fails in its own way
            yield name, f"{type(reason).__name__}: {reason}"


class Figures(NamedTuple):
    """Over a size's instances: median ms to solve and to prepare; how many are solved exactly, and as the relaxation."""

    solve: float
    prepare: float
    exact: int
    relaxed: int


def measure(n: int, repeat: int, file: str) -> tuple[dict[str, Figures], dict[str, str]]:
    """Every solver's figures, and the reasons of those skipped."""
    problems = instances(n)
    found = dict(peers(problems, file))
    skipped = {name: made for name, made in found.items() if isinstance(made, str)}
    makers = {name: made for name, made in found.items() if not isinstance(made, str)}
    solve, prepare = (np.full((len(found), len(problems), repeat), np.nan) for _ in range(2))
    exact, relaxed = np.zeros((2, len(found), len(problems)), dtype=bool)
    for k, problem in enumerate(problems):
        solves = {name: make(problem) for name, make in makers.items()}
        if k == 0:
            for each in solves.values():  # compile, load, allocate
                each()
        for turn in range(repeat):
            for row, (name, make) in enumerate(makers.items()):
                if turn and np.nanmax(solve[row, k]) > SLOW:
                    continue
                solve[row, k, turn], impulse = solves[name]()
                exact[row, k] = residual(problem, impulse) <= SOLVED
                relaxed[row, k] = relaxation_residual(problem, impulse) <= SOLVED
                if not name.startswith(("PATH", "Siconos")):
                    fresh, start = problem.fresh(), perf_counter()
                    make(fresh)
                    prepare[row, k, turn] = perf_counter() - start
    figures = {}
    for row, name in enumerate(makers):
        counted = relaxed[row] if name.startswith("relaxation") else exact[row]
        seconds = np.where(counted, np.nanmedian(solve[row], axis=1), np.inf)
        ready = np.nan if np.isnan(prepare[row]).all() else np.nanmedian(prepare[row])
        figures[name] = Figures(
            1e3 * float(np.median(seconds)), 1e3 * float(ready), int(exact[row].sum()), int(relaxed[row].sum())
        )
    return figures, skipped


def table(head: str, sizes: list[int], rows: dict[str, list[str]]) -> str:
    lines = [
        [head, *(f"n = {n}" for n in sizes)],
        ["---"] * (len(sizes) + 1),
        *([name, *cells] for name, cells in rows.items()),
    ]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def number(x: float) -> str:
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
            figures, why = measure(n, given.repeat, f"{folder}/problems-{n}.npz")
            results.append(figures)
            skipped |= why
            print(f"n = {n} measured", file=sys.stderr)
    names = list(results[0])
    solve_rows, prepare_rows, solved_rows = {}, {}, {}
    for name in names:
        is_relaxation = name.startswith("relaxation")
        solve_rows[name] = [f"{number(r[name].solve)} ({number(r[name].solve / r['hybrid'].solve)})" for r in results]
        solved_rows[name] = [f"{r[name].exact}, {r[name].relaxed}" if is_relaxation else str(r[name].exact) for r in results]
        if np.isfinite(results[0][name].prepare):
            prepare_rows[name] = [number(r[name].prepare) for r in results]
    print(table("solve, ms (over hybrid's)", sizes, solve_rows))
    print(table(f"solved to {SOLVED:g}, of 12 (a relaxation: exactly, as such)", sizes, solved_rows))
    print(table("prepare, ms", sizes, prepare_rows))
    print("\n".join(f"skipped: {name}: {why}" for name, why in skipped.items()))


main()
