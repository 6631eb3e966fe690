"""Solvers that come with CasADi: its active-set method QRQP and qpOASES on the relaxation's dual, Ipopt on the friction LCP.

The dual in the plane is min ½ z'H z + g'z over z >= 0 (solvers.outside.scaled_delassus); the LCP is the nonconvex program

    min  z'w    subject to    w = M z + q,  z >= 0,  w >= 0,

with a sparse M: solutions have the value 0, a local minimum may have another, or 0 only up to Ipopt's barrier.

Licence: CasADi LGPL-3.0; it bundles qpOASES (LGPL-2.1) and Ipopt (EPL-2.0).
Form: for qrqp and qpoases the dual, dense and dimensionless, for qrqp with 1e-12 on the diagonal, as it fails on singular ones;
    for ipopt the friction LCP's M, scaled, and q. Setup: for ipopt M's compressed columns. Solve: the call, from 0, of CasADi's
    solver object, which is made once for each tolerance and size, for ipopt for each tolerance and sparsity.
Clock: CasADi's, around the solver, for qpoases.
Settings: their defaults, without output, and for ipopt that derivatives are constant. Ipopt relaxes bounds by
    bound_relax_factor = 1e-8; tuned is 0, `frictionbench solve 'stack[blocks=5,push=1]' --solver 'casadi[method=ipopt]'
    --solver 'casadi[method=ipopt,settings=tuned]'`.
Tolerance: qpoases terminationTolerance = eps/10, but not less than 1e-12, eps as in solvers.outside.scaled_delassus; qrqp's, of
    1e-8, are left, as larger ones end it far from the solution; ipopt tol = (eps/10)^2, not less than 1e-15, as z'w is a
    product, eps as in solvers.pivots.dense_lcp, and success is claimed where min(z, w) is at most eps/10 in size.
Flaws: ipopt seldom reaches 1e-8 by default: relaxed bounds, `frictionbench solve stack --solver 'casadi[method=ipopt]'`.
Reference: Andersson and others 2019, CasADi; Ferreau and others 2014 (qpOASES); Wächter and Biegler 2006 (Ipopt).
"""

from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Model, Status, solver
from frictionbench.solvers.outside import STOPPING_MARGIN
from frictionbench.solvers.outside.scaled_delassus import DualProgram, dual_program
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

_DEFINITE = {"qrqp": 1e-12, "qpoases": 0.0}  # on a diagonal of about 1
_OPTIONS: dict[str, dict[str, Any]] = {
    "qrqp": {"print_iter": False, "print_header": False, "print_info": False},
    "qpoases": {"printLevel": "none"},
    "ipopt": {"print_level": 0, "sb": "yes", "hessian_constant": "yes", "jac_c_constant": "yes"},
}


@solver(
    "casadi",
    family="outside",
    model="relaxation",
    needs=("casadi",),
    lacks=("friction_bias", "asymmetry"),
    variants=(*(f"method={method}" for method in _OPTIONS), "method=ipopt,settings=tuned"),
)
class CasADi:
    """CasADi's QRQP or qpOASES on the relaxation's dual, or Ipopt on the friction LCP. (outside)

    method: qrqp, qpoases or ipopt. settings: default or tuned. Work: iterations.
    """

    method: str = "qrqp"
    settings: str = "default"

    @property
    def model(self) -> Model:
        return "lcp" if self.method == "ipopt" else "relaxation"

    @property
    def dimension(self) -> tuple[int, ...]:
        return (2, 3) if self.method == "ipopt" else (2,)

    @property
    def lacks(self) -> tuple[str, ...]:
        return () if self.method == "ipopt" else ("friction_bias", "asymmetry")

    def form(self, problem: FrictionProblem) -> DualProgram | DenseLCP:
        return dense_lcp(problem) if self.method == "ipopt" else dual_program(problem, _DEFINITE[self.method])

    def setup(self, formed: DualProgram | DenseLCP) -> DualProgram | DenseLCP:
        return formed._replace(M=sparse.csc_matrix(formed.M)) if isinstance(formed, DenseLCP) else formed

    def solve(self, prepared: DualProgram | DenseLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        if isinstance(prepared, DenseLCP):
            return _by_ipopt(prepared, tol * prepared.share / STOPPING_MARGIN, limit or 3000, self.settings == "tuned")
        eps = max(tol * prepared.scaled.share / STOPPING_MARGIN, 1e-12)
        library_solver = _quadratic(self.method, len(prepared.g), eps if self.method == "qpoases" else 0.0, limit or 10_000)
        result = library_solver(h=prepared.H, g=prepared.g, lbx=0.0, ubx=np.inf)
        stats = library_solver.stats()
        detail, clock = stats["unified_return_status"], stats.get("t_wall_solver")
        z = np.array(result["x"]).ravel()
        return prepared.answer(z, stats["success"], tol, detail, clock, iterations=int(stats["iter_count"]))


@lru_cache(maxsize=16)
def _quadratic(method: str, n: int, eps: float, limit: int) -> Any:
    """CasADi's solver of dense programs of n unknowns over z >= 0; eps is for qpoases."""
    casadi: Any = import_module("casadi")
    options = {"max_iter": limit} if method == "qrqp" else {"terminationTolerance": eps, "nWSR": limit}
    sparsity = {"h": casadi.Sparsity.dense(n, n), "a": casadi.Sparsity(0, n)}
    return casadi.conic("solver", method, sparsity, options | _OPTIONS[method] | {"error_on_fail": False})


def _by_ipopt(lcp: DenseLCP, eps: float, limit: int, tuned: bool) -> Answer:
    n = len(lcp.q)
    M: Any = lcp.M  # in compressed columns
    library_solver = _complementarity(n, M.indptr.tobytes(), M.indices.tobytes(), max(eps**2, 1e-15), limit, tuned)
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
    ipopt = _OPTIONS["ipopt"] | {"tol": tol, "max_iter": limit} | ({"bound_relax_factor": 0.0} if tuned else {})
    program = {
        "x": casadi.veccat(z, w),
        "p": casadi.veccat(entries, q),
        "f": casadi.dot(z, w),
        "g": casadi.MX(pattern, entries) @ z + q - w,
    }
    return casadi.nlpsol("solver", "ipopt", program, {"ipopt": ipopt, "print_time": False})
