"""PATH through GAMSPy, where it is installed: the package includes a demonstration licence that forbids commercial use, covers
at most 1000 rows and may expire. It is never a dependency.

Licence: GAMSPy MIT; GAMS and PATH proprietary, with a demonstration licence in the package gamspy_base. GAMS' free licences
    are for academic or personal use and for five months; results may be published only with the method documented and with no
    COPT, CPLEX, Gurobi, Knitro, LINDO or Xpress in the table. Its library is not linked here.
Form: the friction LCP's M, dense and scaled, and q. Setup: the records of GAMSPy's model, which is made once for each size.
    Solve: GAMSPy's call from z = 0, with GAMS' compilation of the model and its processes.
Clock: the total time in PATH's own log, including GAMS' evaluation of M z + q. PATH is compared by it, as GAMS is another
    process: the column solve_time is this clock, and call_time the records and GAMSPy's call.
Settings: its defaults. GAMSPy's freeze is for a sequence of problems with one M; those of a suite differ in M.
Tolerance: convergence_tolerance = eps/10, on PATH's residual of the scaled LCP; eps is tol times the least unit of a contact
    in it (solvers.pivots.dense_lcp).
Flaws: beyond the licence's 1000 rows GAMS does not call PATH; the answer is then
    `unsolved` with that reason, which says nothing about PATH.
Reference: Dirkse and Ferris 1995; Ferris and Munson 1999.
"""

import io
import re
from functools import lru_cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside import MARGIN
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

_SILENT = ("crash_iterations", "major_iterations", "minor_iterations", "initial_point_statistics", "final_point_statistics")


class Model(NamedTuple):
    """GAMSPy's symbols of the model w = M z + q >= 0, z >= 0, w_i z_i = 0 over the set i."""

    M: Any
    q: Any
    z: Any
    model: Any


@solver("path", family="pivoting", model="lcp", dimension=(2, 3), needs=("gamspy",), remote=True)
class Path:
    """PATH, a pivoting Newton method for complementarity problems, through GAMSPy. (outside)

    Work: pivots (minor iterations) if the log contains them.
    """

    def form(self, problem: FrictionProblem | LCP) -> DenseLCP:
        return dense_lcp(problem)

    def setup(self, given: DenseLCP) -> DenseLCP:
        path = _model(len(given.q))
        path.M.setRecords(given.M)
        path.q.setRecords(given.q)
        return given

    def solve(self, given: DenseLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        gp: Any = import_module("gamspy")
        path = _model(len(given.q))
        path.z.setRecords(np.zeros(len(given.q)))
        log = io.StringIO()
        options = {f"output_{name}": "no" for name in _SILENT} | {"convergence_tolerance": tol * given.share / MARGIN}
        if limit:
            options["cumulative_iteration_limit"] = limit
        try:
            path.model.solve(solver="path", solver_options=options, output=log, options=gp.Options(solve_link_type="memory"))
        except gp.exceptions.GamspyException as error:
            if "license" not in str(error):
                raise
            return given.scaled.answer(
                np.zeros(len(given.q)), Status.FAILED, "not attempted: the problem is larger than the GAMS licence allows"
            )
        total = re.search(r"Total Time[. ]*([\d.]+)", log.getvalue())
        minor = re.search(r"Minor Iterations[. ]*(\d+)", log.getvalue())
        status = Status.SOLVED if path.model.status.name in ("OptimalGlobal", "OptimalLocal") else Status.FAILED
        work = {"pivots": int(minor[1])} if minor else {}
        return given.scaled.answer(
            path.z.records["level"].to_numpy(), status, path.model.status.name, float(total[1]) if total else None, **work
        )


@lru_cache(maxsize=8)
def _model(n: int) -> Model:
    gp: Any = import_module("gamspy")
    gp.set_options({"ALLOW_AMBIGUOUS_EQUATIONS": "yes"})
    m = gp.Container()
    i = gp.Set(m, "i", records=[str(k) for k in range(n)])
    j = gp.Alias(m, "j", alias_with=i)
    M, q = gp.Parameter(m, "M", domain=[i, j]), gp.Parameter(m, "q", domain=[i])
    z, w = gp.Variable(m, "z", type="positive", domain=[i]), gp.Equation(m, "w", domain=[i])
    w[i] = gp.Sum(j, M[i, j] * z[j]) + q[i] >= 0
    return Model(M, q, z, gp.Model(m, "lcp", problem="MCP", matches={w: z}))
