"""Ipopt, which comes with CasADi, on the friction LCP as the nonconvex program

    min  z'w    subject to    w = M z + q,  z >= 0,  w >= 0,

with a sparse M, and possibly free unknowns for which w = 0 (solvers.outside.mixed_lcp): solutions have the value 0, a local
minimum may have another, or 0 only up to Ipopt's barrier.
"""

from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside import STOPPING_MARGIN, untimed
from frictionbench.solvers.outside.mixed_lcp import Mixed, mixed_lcp
from frictionbench.solvers.pivots.dense_lcp import DenseLCP


@solver(
    "casadi",
    family="outside",
    model="lcp",
    dimension=(2, 3),
    needs=("casadi",),
    variants=("settings=default", "settings=tuned", "settings=velocities"),
)
class CasADi:
    """Ipopt on the friction LCP, through CasADi. (outside)

    settings: default, tuned or velocities. Work: iterations.

    Licence: CasADi LGPL-3.0; it bundles Ipopt (EPL-2.0).
    Form: the friction LCP's M, scaled, and q, in the plane with three unknowns a contact; with settings=velocities the mixed
        problem of velocities, impulses and the joints' multipliers, where the mechanics are known. Setup: M's compressed
        columns. Solve: the call, from 0, of CasADi's solver object, which is made once for each tolerance and sparsity.
    Clock: none.
    Settings: their defaults, without output, and that derivatives are constant. Ipopt relaxes bounds by bound_relax_factor =
        1e-8 and begins with a barrier of mu_init = 0.1; tuned are 0 and 1, `frictionbench solve 'stack[blocks=5,push=1]'
        --solver casadi --solver 'casadi[settings=tuned]'`; velocities is tuned with the mixed problem, `frictionbench solve
        'stack[blocks=10,mass_ratio=1e2,push=1]' --solver 'casadi[settings=tuned]' --solver 'casadi[settings=velocities]'`.
    Tolerance: tol = (eps/10)^2, as z'w is a product, not less than 1e-14, which it reaches; eps as in
        solvers.pivots.dense_lcp, and success is claimed where min(z, w) is at most eps/10 in size.
    Flaws: it seldom reaches 1e-8 by default: relaxed bounds, `frictionbench solve stack --solver casadi`. It claims no
        success for some accurate answers without friction or with velocities (Search_Direction_Becomes_Too_Small).
    Reference: Andersson and others 2019, CasADi; Wächter and Biegler 2006 (Ipopt).
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Mixed:
        return mixed_lcp(problem, velocities=self.settings == "velocities")

    def setup(self, mixed: Mixed) -> tuple[DenseLCP, Any, Array]:
        lcp, M, q = mixed
        return lcp, sparse.csc_matrix(M), q

    def solve(self, prepared: tuple[DenseLCP, Any, Array], tol: float, limit: int | None, start: Array | None = None) -> Answer:
        lcp, M, q = prepared
        n, free, eps = len(lcp.q), len(q) - len(lcp.q), tol * lcp.share / STOPPING_MARGIN
        pattern = M.indptr.tobytes(), M.indices.tobytes()
        library_solver = _complementarity(n, free, *pattern, max(eps**2, 1e-14), limit or 3000, self.settings != "default")
        lower = np.repeat([-np.inf, 0.0], [free, 2 * n])
        result = library_solver(x0=0.0, lbx=lower, lbg=0.0, ubg=0.0, p=np.concatenate([M.data, q]))
        y, stats = np.array(result["x"]).ravel()[free + n :], library_solver.stats()
        accurate = np.abs(np.minimum(y, lcp.M @ y + lcp.q)).max() <= eps
        status = Status.SOLVED if stats["success"] and accurate else Status.FAILED
        return lcp.scaled.answer(y, status, stats["return_status"], iterations=int(stats["iter_count"]))


@lru_cache(maxsize=16)
def _complementarity(n: int, free: int, starts: bytes, rows: bytes, tol: float, limit: int, tuned: bool) -> Any:
    """CasADi's solver by Ipopt of the program z'w of an LCP of n unknowns, with further free ones, whose parameters are the
    entries of M, and q."""
    casadi: Any = import_module("casadi")
    names = ("u", "w", "z", "M", "q")  # u: the free unknowns
    pattern = casadi.Sparsity(n + free, n + free, *(np.frombuffer(each, np.int32).tolist() for each in (starts, rows)))
    u, w, z, entries, q = map(casadi.MX.sym, names, (free, n, n, pattern.nnz(), n + free))
    equations = casadi.MX(pattern, entries) @ casadi.veccat(z, u) + q
    constant = {"print_level": 0, "sb": "yes", "hessian_constant": "yes", "jac_c_constant": "yes"}
    ipopt = constant | {"tol": tol, "max_iter": limit} | ({"bound_relax_factor": 0.0, "mu_init": 1.0} if tuned else {})
    program = {
        "x": casadi.veccat(u, w, z),  # in this order the factors mostly have less fill
        "p": casadi.veccat(entries, q),
        "f": casadi.dot(z, w),
        "g": casadi.veccat(equations[n:], equations[:n] - w),
    }
    with untimed():
        return casadi.nlpsol("solver", "ipopt", program, {"ipopt": ipopt, "print_time": False})
