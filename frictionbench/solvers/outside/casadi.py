"""Ipopt, which comes with CasADi, on the friction LCP as the nonconvex program

    min  z'w    subject to    w = M z + q,  z >= 0,  w >= 0,

with a sparse M: solutions have the value 0, a local minimum may have another, or 0 only up to Ipopt's barrier.
"""

from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside import STOPPING_MARGIN
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp


@solver(
    "casadi",
    family="outside",
    model="lcp",
    dimension=(2, 3),
    needs=("casadi",),
    variants=("settings=default", "settings=tuned"),
)
class CasADi:
    """Ipopt on the friction LCP, through CasADi. (outside)

    settings: default or tuned. Work: iterations.

    Licence: CasADi LGPL-3.0; it bundles Ipopt (EPL-2.0).
    Form: the friction LCP's M, scaled, and q. Setup: M's compressed columns. Solve: the call, from 0, of CasADi's solver
        object, which is made once for each tolerance and sparsity.
    Clock: none.
    Settings: their defaults, without output, and that derivatives are constant. Ipopt relaxes bounds by bound_relax_factor =
        1e-8; tuned is 0, `frictionbench solve 'stack[blocks=5,push=1]' --solver casadi --solver 'casadi[settings=tuned]'`.
    Tolerance: tol = (eps/10)^2, not less than 1e-15, as z'w is a product, eps as in solvers.pivots.dense_lcp, and success is
        claimed where min(z, w) is at most eps/10 in size.
    Flaws: it seldom reaches 1e-8 by default: relaxed bounds, `frictionbench solve stack --solver casadi`.
    Reference: Andersson and others 2019, CasADi; Wächter and Biegler 2006 (Ipopt).
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> DenseLCP:
        return dense_lcp(problem)

    def setup(self, lcp: DenseLCP) -> DenseLCP:
        return lcp._replace(M=sparse.csc_matrix(lcp.M))

    def solve(self, lcp: DenseLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        n, eps = len(lcp.q), tol * lcp.share / STOPPING_MARGIN
        M: Any = lcp.M  # in compressed columns
        pattern = M.indptr.tobytes(), M.indices.tobytes()
        library_solver = _complementarity(n, *pattern, max(eps**2, 1e-15), limit or 3000, self.settings == "tuned")
        result = library_solver(x0=0.0, lbx=0.0, lbg=0.0, ubg=0.0, p=np.concatenate([M.data, lcp.q]))
        y, stats = np.array(result["x"]).ravel()[:n], library_solver.stats()
        accurate = np.abs(np.minimum(y, M @ y + lcp.q)).max() <= eps
        status = Status.SOLVED if stats["success"] and accurate else Status.FAILED
        return lcp.scaled.answer(y, status, stats["return_status"], iterations=int(stats["iter_count"]))


@lru_cache(maxsize=16)
def _complementarity(n: int, starts: bytes, rows: bytes, tol: float, limit: int, tuned: bool) -> Any:
    """CasADi's solver by Ipopt of the program z'w of an LCP of n unknowns, whose parameters are the entries of M, and q."""
    casadi: Any = import_module("casadi")
    pattern = casadi.Sparsity(n, n, *(np.frombuffer(each, np.int32).tolist() for each in (starts, rows)))
    z, w, entries, q = (casadi.MX.sym(name, size) for name, size in (("z", n), ("w", n), ("M", pattern.nnz()), ("q", n)))
    constant = {"print_level": 0, "sb": "yes", "hessian_constant": "yes", "jac_c_constant": "yes"}
    ipopt = constant | {"tol": tol, "max_iter": limit} | ({"bound_relax_factor": 0.0} if tuned else {})
    program = {
        "x": casadi.veccat(z, w),
        "p": casadi.veccat(entries, q),
        "f": casadi.dot(z, w),
        "g": casadi.MX(pattern, entries) @ z + q - w,
    }
    return casadi.nlpsol("solver", "ipopt", program, {"ipopt": ipopt, "print_time": False})
