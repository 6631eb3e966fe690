"""Each solver of tests/benchmarks/peers.py behind one call: make it ready for a problem, then solve as often as asked.

A maker returns prepare(problem) -> solve, and solve() -> (seconds, impulses). It raises where its library is absent.
What the seconds hold is said in each docstring; a solve is repeated for BUDGET and the least time counts.
"""

import io
import json
import re
import select
import subprocess
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from problems import FrictionProblem, scene
from problems.check import Array
from solvers import find
from solvers.outside.scaled_program import gap_tolerance, scaled_program

SOLVED = 1e-8  # the residual to reach; our solvers and the relaxation's are asked for it
TOLERANCE = 1e-9  # asked of the other libraries, whose tolerance is of another measure
BUDGET, LIMIT = 2e-3, 5.0  # s: to repeat a solve; after which a child process is killed
SICONOS_PYTHON = "/usr/bin/python3"

Solve = Callable[[], tuple[float, Array]]
Prepare = Callable[[FrictionProblem], Solve]


def clocked(call: Callable[[], Any], impulse: Callable[[Any], Array]) -> Solve:
    """Least seconds of the call alone; turning its result into impulses (nc, d) is not timed."""

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
    """A solver of this repository: its solve, from the prepared problem to the Answer with its impulses."""
    _, solver = find(spec)

    def prepare(problem: FrictionProblem) -> Solve:
        prepared = solver.prepare(problem)
        return clocked(lambda: solver.solve(prepared, SOLVED, None), lambda answer: answer.impulse)

    return prepare


def quantecon(tol_ratio_diff: float | None = None) -> Prepare:
    """QuantEcon's lcp_lemke, a dense tableau in numba: the call, with M dense and q at hand, to z."""
    from quantecon.optimize import PivOptions
    from quantecon.optimize.lcp_lemke import lcp_lemke

    def prepare(problem: FrictionProblem) -> Solve:
        lcp = problem.lcp()
        M, q, limit = lcp.dense.copy(), lcp.q.copy(), 100_000
        options = () if tol_ratio_diff is None else (PivOptions(tol_ratio_diff=tol_ratio_diff),)
        return clocked(lambda: lcp_lemke(M, q, None, limit, *options), lambda result: lcp.impulse(result.z))

    return prepare


def path() -> Prepare:
    """PATH through GAMSPy: the total time in PATH's own log, the least of three solves from z = 0, without GAMS around it."""
    import gamspy as gp

    gp.set_options({"ALLOW_AMBIGUOUS_EQUATIONS": "yes"})  # type: ignore[dict-item]
    silent = ("crash_iterations", "major_iterations", "minor_iterations", "initial_point_statistics", "final_point_statistics")
    options = {f"output_{name}": "no" for name in silent} | {"convergence_tolerance": TOLERANCE}

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

    prepare(scene("stack", blocks=1).problem())()  # fails here where the demonstration licence has expired
    return prepare


def siconos(solver: str, number: dict[int, int], file: str) -> Prepare:
    """Siconos in a child process that reads the problems from a file: the driver's call, with W or M dense, to r or z.

    number: each problem's in the file, by its id.
    """
    script = str(Path(__file__).with_name("siconos_child.py"))
    found = subprocess.run([SICONOS_PYTHON, "-c", "import siconos.numerics"], capture_output=True, check=False)
    if found.returncode:
        raise ImportError(f"python3-siconos not installed for {SICONOS_PYTHON}")

    def start() -> subprocess.Popen[str]:
        command = [SICONOS_PYTHON, script, file, solver]
        pipe = subprocess.PIPE
        return subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True, bufsize=1)

    child = start()

    def ask(k: int) -> str:
        nonlocal child
        child.stdin.write(f"{k}\n")  # type: ignore[union-attr]
        reply = child.stdout.readline() if select.select([child.stdout], [], [], LIMIT)[0] else ""  # type: ignore[union-attr]
        if not reply:  # it hangs, or has aborted
            child.kill()
            child.wait()
            child = start()
        return reply

    def prepare(problem: FrictionProblem) -> Solve:
        def solve() -> tuple[float, Array]:
            reply = ask(number[id(problem)])
            if not reply:
                return np.inf, np.full((problem.contacts, problem.dimension), np.nan)
            seconds, answer = json.loads(reply)
            if solver.startswith("LCP"):
                return seconds, problem.lcp().impulse(np.array(answer))
            return seconds, np.array(answer).reshape(problem.contacts, -1)[:, : problem.dimension]

        return solve

    return prepare


def relaxation(backend: str, dense: bool = False, **settings: Any) -> Prepare:
    """The convex relaxation, scaled as in our ccp: qpsolvers' call, with the backend's setup and its own cost."""
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


def planar_makers(number: dict[int, int], file: str) -> dict[str, Callable[[], Prepare]]:
    """Every solver of the comparison in the plane by its name in the tables; number and file as in siconos."""
    gap = gap_tolerance(SOLVED, round_cones=False)
    piqp = {"eps_abs": SOLVED, "eps_rel": 0.0, "eps_duality_gap_abs": gap, "eps_duality_gap_rel": 0.0}
    return {
        "hybrid": lambda: ours("hybrid"),
        "lemke": lambda: ours("lemke"),
        "path_search": lambda: ours("path_search"),
        "interior_point": lambda: ours("interior_point"),
        "nsgs": lambda: ours("nsgs"),
        "QuantEcon lcp_lemke": quantecon,
        "QuantEcon, tol_ratio_diff 1e-10": lambda: quantecon(1e-10),
        "PATH 5.2 (GAMSPy)": path,
        "Siconos LCP LEMKE": lambda: siconos("LCP_LEMKE", number, file),
        "Siconos 2-D NSGS": lambda: siconos("FRICTION_2D_NSGS", number, file),
        "Siconos 3-D PROX": lambda: siconos("FRICTION_3D_PROX", number, file),
        "Siconos 3-D ADMM": lambda: siconos("FRICTION_3D_ADMM", number, file),
        "relaxation: proxqp": lambda: ours("ccp[backend=proxqp]"),
        "relaxation: clarabel": lambda: ours("ccp[backend=clarabel]"),
        "relaxation: osqp": lambda: ours("ccp[backend=osqp]"),
        "relaxation: piqp": lambda: relaxation("piqp", **piqp),
        "relaxation: daqp": lambda: relaxation("daqp", dense=True, primal_tol=TOLERANCE, dual_tol=TOLERANCE),
        "relaxation: quadprog": lambda: relaxation("quadprog", dense=True),
        "relaxation: relaxation_ip": lambda: ours("relaxation_ip"),
    }


def spatial_makers(number: dict[int, int], file: str) -> dict[str, Callable[[], Prepare]]:
    """The same in space, with the circular cone."""
    exact = ("hybrid", "interior_point", "nsgs", "nncg", "apgd_coulomb", "admm_coulomb")
    theirs = ("NSGS", "PROX", "ADMM", "NSN_AC")
    relaxed = ("ccp_cone[backend=clarabel]", "apgd", "relaxation_ip")
    return (
        {spec: lambda spec=spec: ours(spec) for spec in exact}
        | {f"Siconos {name}": lambda name=name: siconos(f"FRICTION_3D_{name}", number, file) for name in theirs}
        | {f"relaxation: {spec}": lambda spec=spec: ours(spec) for spec in relaxed}
    )
