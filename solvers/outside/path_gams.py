"""PATH through GAMSPy, where it is installed: the package includes a demonstration licence that forbids commercial use, covers
at most 1000 rows and may expire. It is never a dependency.

Licence: GAMSPy MIT; GAMS and PATH proprietary, with a demonstration licence in the package gamspy_base.
Form: the friction LCP's M, dense and scaled, and q. Setup: GAMSPy's container and model. Solve: GAMSPy's call from z = 0, which
    includes 30 to 100 ms of GAMS.
Clock: the total time in PATH's own log, including GAMS' evaluation of M z + q.
Tolerance: convergence_tolerance = tol/10, on PATH's residual of the scaled LCP.
Flaws: the wall time is mostly GAMS'; use the clock. Beyond the licence's 1000 rows GAMS does not call PATH; the answer is then
    `unsolved` with that reason, which says nothing about PATH.
Reference: Dirkse and Ferris 1995; Ferris and Munson 1999.
"""

import io
import re
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.margin import MARGIN
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

_SILENT = ("crash_iterations", "major_iterations", "minor_iterations", "initial_point_statistics", "final_point_statistics")


class Prepared(NamedTuple):
    given: DenseLCP
    model: Any
    z: Any
    rows: Any


@solver("path", family="pivoting", model="lcp", dimension=(2, 3), needs=("gamspy",))
class Path:
    """PATH, a pivoting Newton method for complementarity problems, through GAMSPy. (outside)

    Work: pivots (minor iterations) if the log contains them.
    """

    def form(self, problem: FrictionProblem | LCP) -> DenseLCP:
        return dense_lcp(problem)

    def setup(self, given: DenseLCP) -> Prepared:
        gp: Any = import_module("gamspy")
        gp.set_options({"ALLOW_AMBIGUOUS_EQUATIONS": "yes"})
        m = gp.Container()
        i = gp.Set(m, "i", records=[str(k) for k in range(len(given.q))])
        j = gp.Alias(m, "j", alias_with=i)
        M, q = gp.Parameter(m, "M", domain=[i, j], records=given.M), gp.Parameter(m, "q", domain=[i], records=given.q)
        z, w = gp.Variable(m, "z", type="positive", domain=[i]), gp.Equation(m, "w", domain=[i])
        w[i] = gp.Sum(j, M[i, j] * z[j]) + q[i] >= 0
        return Prepared(given, gp.Model(m, "lcp", problem="MCP", matches={w: z}), z, i)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        gp: Any = import_module("gamspy")
        given, model, z, i = prepared
        if not len(given.q):
            return given.answer(np.zeros(0), Status.SOLVED)
        z.l[i] = 0
        log = io.StringIO()
        options = {f"output_{name}": "no" for name in _SILENT} | {"convergence_tolerance": tol / MARGIN}
        if limit:
            options["cumulative_iteration_limit"] = limit
        try:
            model.solve(solver="path", solver_options=options, output=log, options=gp.Options(solve_link_type="memory"))
        except gp.exceptions.GamspyException as error:
            if "license" not in str(error):
                raise
            return given.answer(
                np.zeros(len(given.q)), Status.FAILED, "not attempted: the problem is larger than the GAMS licence allows"
            )
        total = re.search(r"Total Time[. ]*([\d.]+)", log.getvalue())
        minor = re.search(r"Minor Iterations[. ]*(\d+)", log.getvalue())
        status = Status.SOLVED if model.status.name in ("OptimalGlobal", "OptimalLocal") else Status.FAILED
        work = {"pivots": int(minor[1])} if minor else {}
        return given.answer(
            z.records["level"].to_numpy(), status, model.status.name, float(total[1]) if total else None, **work
        )
