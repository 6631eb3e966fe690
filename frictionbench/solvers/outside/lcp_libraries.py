"""The friction LCP by libraries of LCPs: Drake's two solvers, PATH through GAMSPy, and QuantEcon's Lemke method.

All receive a dense, scaled M and q (solvers.pivots.dense_lcp, for pivoting methods in the plane solvers.outside.planar_lcp);
a variant of Drake one that is not scaled row by row, and PATH also the mixed problem in velocities and impulses.
"""

import io
import re
from functools import lru_cache, partial
from importlib import import_module
from typing import Any

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside import STOPPING_MARGIN
from frictionbench.solvers.outside.mixed_lcp import Mixed, mixed_lcp
from frictionbench.solvers.outside.planar_lcp import smallest_lcp
from frictionbench.solvers.pivots.dense_lcp import DenseLCP

lcp_library = partial(solver, family="pivoting", model="lcp", dimension=(2, 3))  # registers an adapter
_DRAKE = {"moby": "MobyLcpSolver", "unrevised": "UnrevisedLemkeSolver"}
_SMALL = 1e-4  # the size of q for Drake, whose tolerances are absolute
_SILENT = ("crash_iterations", "major_iterations", "minor_iterations", "initial_point_statistics", "final_point_statistics")
_PATH = "default", "tuned", "velocities"
_ENDED = {0: Status.SOLVED, 1: Status.WORK_LIMIT, 2: Status.RAY}


@lcp_library("drake", needs=("drake",), variants=("method=moby", "method=unrevised", "method=unrevised,unknowns=4"))
class Drake:
    """Drake's solvers of LCPs: MobyLcp or UnrevisedLemke. (outside)

    method: moby or unrevised. unknowns: 3 or 4 per contact in the plane. Work: none is reported.

    Licence: BSD-3-Clause; the wheel bundles proprietary libraries that none of these solvers calls.
    Form: the friction LCP's M, dense, and q, scaled row by row, in the plane with three unknowns a contact; with unknowns=4 in
        one unit of impulses and one of velocities, whose ties are exact, in the plane with four. Setup: a MathematicalProgram
        with that one constraint. Solve: a new solver object, as a reused one starts from its last basis, and its Solve.
    Clock: none.
    Settings: its defaults; there are no options. Their tolerances are absolute: they find ties, and fail less often, with q of
        size 1e-4. UnrevisedLemke solves some problems in one form only, `frictionbench solve 'stack[blocks=8,mass_ratio=100]'
        --solver 'drake[method=unrevised]' --solver 'drake[method=unrevised,unknowns=4]'`.
    Tolerance: it takes none; both check their solutions against zero tolerances of their own, which are left at their defaults.
    Flaws: of ties UnrevisedLemke takes one not yet taken in this basis, or fails, as in this example. MobyLcp, whose retries
        solve with M + lambda I, lambda up to 1e-4 at least (SolveLcpLemkeRegularized), reports success for inexact answers,
        `frictionbench solve 'stack[blocks=8,mass_ratio=1e4]' --solver 'drake[method=moby]'`.
    Reference: Tedrake and others, Drake; Dai and Drumwright, "Computing the Principal Pivoting Transform" (UnrevisedLemke).
    """

    method: str = "moby"
    unknowns: int = 3

    def form(self, problem: FrictionProblem | LCP) -> tuple[Any, ...]:
        """The LCP, M and q for Drake, and the unit of z."""
        if self.unknowns == 3:
            scaled = smallest_lcp(problem)
            return scaled, scaled.M, _SMALL * scaled.q, 1 / _SMALL
        lcp = problem if isinstance(problem, LCP) else problem.lcp()
        M, q, k = lcp.dense.copy(), lcp.q.copy(), lcp.size - lcp.contacts[0]  # k impulses, then sliding speeds
        mass = 2.0 ** -round(np.log2(M[:k].trace() / k)) if M[:k].trace() > 0 else 1.0  # the unit of impulses
        M[:k, :k] *= mass
        q[k:] /= mass
        size = _SMALL / (np.abs(q).max(initial=0.0) or 1.0)
        return lcp, M, size * q, np.where(np.arange(len(q)) < k, mass, 1.0) / size

    def setup(self, form: tuple[Any, ...]) -> tuple[Any, ...]:
        lcp, M, q, unit = form
        program = import_module("pydrake.solvers").MathematicalProgram()
        z = program.NewContinuousVariables(len(q))
        program.AddLinearComplementarityConstraint(M, q, z)
        return lcp, unit, program, z

    def solve(self, prepared: tuple[Any, ...], tol: float, limit: int | None, start: Array | None = None) -> Answer:
        lcp, unit, program, unknowns = prepared
        result = getattr(import_module("pydrake.solvers"), _DRAKE[self.method])().Solve(program, None, None)
        z, detail = unit * result.GetSolution(unknowns), result.get_solution_result().name
        status = Status.SOLVED if result.is_success() else Status.FAILED
        return (
            lcp.scaled.answer(z, status, detail) if self.unknowns == 3 else Answer(lcp.impulse(z), status, z=z, detail=detail)
        )


@lcp_library("path", needs=("gamspy",), remote=True, variants=tuple(f"settings={name}" for name in _PATH))
class Path:
    """PATH, a pivoting Newton method for complementarity problems, through GAMSPy. (outside)

    settings: default, tuned or velocities. Work: pivots (minor iterations) if the log contains them.

    Licence: GAMSPy MIT; GAMS and PATH proprietary, with a demonstration licence in the package gamspy_base, which forbids
        commercial use, covers at most 1000 rows and expires (that of 54.6.1 on 26 November 2026): GAMS then fails without a
        reason, and the solver counts as not installed. It is never a dependency. GAMS' free licences are for academic or
        personal use and for five months; results may be published only with the method documented and with no COPT, CPLEX,
        Gurobi, Knitro, LINDO or Xpress in the table. Its library is not linked here.
    Form: the friction LCP's M, dense and scaled, and q, in the plane with three unknowns a contact; with settings=velocities
        the mixed problem, a sparse M, of velocities, impulses and the joints' multipliers, where the mechanics are known.
        Setup: the records of GAMSPy's model, which is made once for each size. Solve: GAMSPy's call from 0, with GAMS'
        compilation of the model and its processes.
    Clock: the total time in PATH's own log, including GAMS' evaluation of M z + q. PATH is compared by it, as GAMS is another
        process: the column solve_time is this clock, and call_time the records and GAMSPy's call.
    Settings: by default a crash method finds a first basis; tuned is crash_method none, `frictionbench solve
        'house_of_cards[storeys=5]' --solver path --solver 'path[settings=tuned]'`; velocities is tuned with the mixed problem.
    Tolerance: convergence_tolerance = eps/10, on PATH's residual of the scaled LCP; eps as in solvers.pivots.dense_lcp.
    Flaws: beyond the licence's 1000 rows GAMS does not call PATH; the answer is `unsolved`, which says nothing about PATH.
    Reference: Dirkse and Ferris 1995; Ferris and Munson 1999.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem | LCP) -> Mixed:
        return mixed_lcp(problem, velocities=self.settings == "velocities")

    def setup(self, mixed: Mixed) -> Mixed:
        M, q, _, _ = _model(len(mixed[2]))
        M.setRecords(mixed[1])
        q.setRecords(mixed[2])
        return mixed

    def solve(self, mixed: Mixed, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        gp: Any = import_module("gamspy")
        lcp, N = mixed[0], len(mixed[2])
        _, _, z, model = _model(N)
        lower = np.where(np.arange(N) < len(lcp.q), 0.0, -np.inf)
        z.setRecords({"level": np.zeros(N), "lower": lower, "upper": np.full(N, np.inf)})
        log = io.StringIO()
        options = {f"output_{name}": "no" for name in _SILENT} | {"convergence_tolerance": tol * lcp.share / STOPPING_MARGIN}
        options |= {} if self.settings == "default" else {"crash_method": "none"}
        options |= {"cumulative_iteration_limit": limit} if limit else {}
        try:
            model.solve(solver="path", solver_options=options, output=log, options=gp.Options(solve_link_type="memory"))
        except gp.exceptions.GamspyException as error:
            if "license" not in str(error):
                raise
            reason = "not attempted: the problem is larger than the GAMS licence allows"
            return lcp.scaled.answer(np.zeros(len(lcp.q)), Status.FAILED, reason)
        total = re.search(r"Total Time[. ]*([\d.]+)", log.getvalue())
        minor = re.search(r"Minor Iterations[. ]*(\d+)", log.getvalue())
        status = Status.SOLVED if model.status.name in ("OptimalGlobal", "OptimalLocal") else Status.FAILED
        work = {"pivots": int(minor[1])} if minor else {}
        y = z.records["level"].to_numpy()[: len(lcp.q)]
        return lcp.scaled.answer(y, status, model.status.name, float(total[1]) if total else None, **work)


@lru_cache(maxsize=8)
def _model(n: int) -> tuple[Any, Any, Any, Any]:
    """GAMSPy's symbols M, q and z, and its model of w = M z + q over the set i, complementary to z and its bounds."""
    gp: Any = import_module("gamspy")
    gp.set_options({"ALLOW_AMBIGUOUS_EQUATIONS": "yes"})
    m = gp.Container()
    i = gp.Set(m, "i", records=[str(k) for k in range(n)])
    j = gp.Alias(m, "j", alias_with=i)
    M, q = gp.Parameter(m, "M", domain=[i, j]), gp.Parameter(m, "q", domain=[i])
    z, w = gp.Variable(m, "z", type="positive", domain=[i]), gp.Equation(m, "w", domain=[i])
    w[i] = gp.Sum(j, M[i, j] * z[j]) + q[i] >= 0
    return M, q, z, gp.Model(m, "lcp", problem="MCP", matches={w: z})


@lcp_library("quantecon", needs=("quantecon",), variants=("settings=default", "settings=tuned"))
class QuantEcon:
    """Lemke's method by QuantEcon, a dense tableau in numba. (outside)

    settings: default or tuned. Work: pivots.

    Licence: MIT.
    Form: the friction LCP's M, dense and scaled, and q, in the plane with three unknowns a contact. Setup: none. Solve:
        lcp_lemke's call.
    Clock: none.
    Settings: tol_ratio_diff, within which two ratios are a tie, is 1e-13 by default; tuned is 1e-8, `frictionbench solve
        'stack[blocks=50,friction=0.05,push=1]' --solver 'quantecon' --solver 'quantecon[settings=tuned]'`.
    Tolerance: it takes none; the solution of a basis is exact up to rounding.
    Flaws: its status is unreliable in both directions: it reports a ray for problems that it has solved, `frictionbench solve
        'stack[blocks=50,friction=0.05,push=1]' --solver quantecon`, and success for inaccurate answers, `frictionbench solve
        'stack[blocks=10,mass_ratio=1e6,push=1]' --solver quantecon`. A dense tableau: time grows with the cube of the contacts.
    Reference: Stachurski, Oyama and others, QuantEcon.py, quantecon.optimize.lcp_lemke.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem | LCP) -> DenseLCP:
        return smallest_lcp(problem)

    def solve(self, prepared: DenseLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        options = import_module("quantecon.optimize").PivOptions(tol_ratio_diff=1e-8 if self.settings == "tuned" else 1e-13)
        lemke: Any = import_module("quantecon.optimize.lcp_lemke").lcp_lemke
        result = lemke(prepared.M, prepared.q, None, limit or 100_000, options)
        return prepared.scaled.answer(result.z, _ENDED.get(result.status, Status.FAILED), pivots=int(result.num_iter))
