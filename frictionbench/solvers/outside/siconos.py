"""Siconos/Numerics in a child process: Debian's python3-siconos, for the system's Python only.

The global form takes mass matrix and Jacobian separately: with v = theta D v^, D = 1/sqrt(M_ii), and r = theta E r^
(solvers.outside.scaled_delassus), M (v - v*) = J'r and u = J v + b become

    M^ v^ = H^ r^ + q^,    u^ = H^'v^ + b^,      M^ = D M D,    H^ = D J'E,    q^ = D M v* / theta,    b^ = E b / theta.

Licence: Apache-2.0. (The metadata of Debian's 4.4.0 state 4.5.0.)
Form: for lcp_ the friction LCP's M, dense and scaled, in the plane for lcp_lemke and lcp_pivot with three unknowns a contact;
    for friction_ the dimensionless Delassus matrix with a decoupled second tangent for friction_3d_ on planar problems, in
    Siconos' block storage, that of its own simulations, and dense where that is faster: for friction_2d_cpg and
    friction_2d_lemke, for admm and prox where W is more than half full and up to 100 and 80 contacts, for friction_2d_nsgs up
    to 48, for vi_eg up to 32, for nsn_fb up to 16, for nsn_ac up to 4 and at any size with settings=dense; for global_, in
    space only, the entries of M and H = J' and q, dimensionless. Setup: none. Solve: one message to the child and its reply.
Clock: around Siconos' problem object and the driver's call, in the child, of matrices in its storage, the third time for what
    takes less than 1 ms. Solvers are compared by it, as a user of Siconos has no child: the column solve_time is this clock,
    and call_time the whole call.
Charged: W's entries and the units cost some 10 µs at 2 contacts, where in the plane a call by hand takes 7 in all.
Settings: tuned is for friction_3d_admm and global_friction_3d_admm the strategy RESIDUAL_BALANCING of rho (by default
    constant), where one residual is PHI = 10 times the other, for the former instead of 2, and a W whose mean diagonal is 4,
    `frictionbench solve 'stack[blocks=10,mass_ratio=100,push=1]' --solver 'siconos[method=friction_3d_admm]' --solver
    'siconos[method=friction_3d_admm,settings=tuned]'`; for friction_3d_nsgs a relaxation of 1.3, `frictionbench
    solve 'stack[blocks=5,push=1]' --solver 'siconos[method=friction_3d_nsgs]' --solver
    'siconos[method=friction_3d_nsgs,settings=tuned]'`; for friction_3d_prox a weight sigma of the proximal term of 0.5
    instead of 5, which is in the units of W, whose mean diagonal is 1, by default 4, `frictionbench solve
    'stack[blocks=3,mass_ratio=1e4,push=1]' --solver 'siconos[method=friction_3d_prox]' --solver
    'siconos[method=friction_3d_prox,settings=tuned]'`. newton is tuned with the local solver ONECONTACT_NSN, but the
    default one where a contact has no friction, as that aborts there. For lcp_lemke and lcp_pivot tuned is q + 1e-10 rand,
    less for slow contacts, without ties, and success where it holds of q, `frictionbench solve 'cubes[boxes=2]' --solver
    'siconos[method=lcp_lemke]' --solver 'siconos[method=lcp_lemke,settings=tuned]'`. lcp_pivot follows Lemke's rule by
    default; lcp_pivot_least_index is the same driver with LEAST_INDEX, `frictionbench solve redundant_table --solver
    'siconos[method=lcp_pivot]' --solver 'siconos[method=lcp_pivot_least_index]'`.
Tolerance: eps/2, for friction_3d_admm tuned eps/4, for global_friction_3d_ipm eps/20, over |q^|, as Siconos divides the norm of
    its natural map by |q|; eps as in solvers.outside.scaled_delassus and, for lcp_, solvers.pivots.dense_lcp. Where |r^| is
    larger it divides by that, and is called again from its own answer with a smaller tolerance, unless that answer's error is
    small enough. The drivers of friction_2d_ begin at 0 whatever their guess is: they are asked at once for eps over 2
    sqrt(contacts), as impulses add up. friction_2d_lemke returns 0 always: no success is claimed if its stated error is larger.
Flaws: friction_2d_lemke ends with wrong answers at ties, and where contacts differ in friction: it takes the row's coefficient
    for the column's, `frictionbench solve 'random[contacts=20]' --solver 'siconos[method=friction_2d_lemke]'`, which lcp_lemke
    does not. friction_2d_cpg and global_friction_3d_ipm at times return 0 for wrong answers. ipm and nsn_fb end in failed
    assertions, and fixed points (aclmfp, tfp) reach the time limit on difficult problems. ONECONTACT_NSN fails where the
    default does not, `frictionbench solve painleve_rod --solver 'siconos[method=friction_3d_nsgs,settings=newton]'`.
Reference: Acary, Brémond and Huber 2018; Acary, Bonnefon, Brémond, Huber, Pérignon and Sinclair 2019, Siconos.
"""

from typing import Any

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.rows import row_of_entry
from frictionbench.solvers.interface import Answer, Model, Status, solver
from frictionbench.solvers.outside.children.child import child
from frictionbench.solvers.outside.planar_lcp import smallest_lcp
from frictionbench.solvers.outside.scaled_delassus import PLANE, SPACE, ScaledDelassus, entries, scaled_delassus
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

PYTHON = "/usr/bin/python3"
_LCP = ("lcp_lemke", "lcp_pivot", "lcp_pivot_least_index", "lcp_newton_fb_fblsa", "lcp_newton_min_fblsa")
_PLANAR = ("friction_2d_nsgs", "friction_2d_cpg", "friction_2d_lemke")
_SPATIAL = tuple(f"friction_3d_{n}" for n in ("nsgs", "vi_eg", "prox", "admm", "nsn_ac", "nsn_fb", "aclmfp", "tfp", "dsfp"))
_GLOBAL = ("global_friction_3d_admm", "global_friction_3d_ipm")
_METHODS = (*_LCP, *_PLANAR, *_SPATIAL, *_GLOBAL)
# The contacts up to which W is dense, measured on 30 problems of 4 to 400 contacts and, for NSN_AC, on robots' steps: beyond,
# block storage is faster, and Newton's methods, which then use another linear solver, fail less often. Sweeps in space are
# never slower with block storage.
_DENSE = {
    **{"friction_2d_cpg": 10**9, "friction_2d_lemke": 10**9, "friction_2d_nsgs": 48, "friction_3d_vi_eg": 32},
    **{"friction_3d_admm": 100, "friction_3d_prox": 80, "friction_3d_nsn_ac": 4, "friction_3d_nsn_fb": 16},
}
_BALANCED = {"SICONOS_FRICTION_3D_ADMM_IPARAM_RHO_STRATEGY": 2}, {"SICONOS_FRICTION_3D_ADMM_BALANCING_RESIDUAL_PHI": 10.0}
_RELAXED = {"SICONOS_FRICTION_3D_NSGS_RELAXATION": 1}, {"SICONOS_FRICTION_3D_NSGS_RELAXATION_VALUE": 1.3}
_LARGER = ("friction_3d_prox", "default"), ("friction_3d_admm", "tuned")  # whose W^ has a mean diagonal of 4
_ASKED = {"friction_3d_admm,settings=tuned": 4, "global_friction_3d_ipm,settings=default": 20}  # eps over the tolerance; 2
_TUNED: dict[str, tuple[dict[str, int], dict[str, float]]] = {
    **{f"friction_3d_nsgs,settings={settings}": _RELAXED for settings in ("tuned", "newton")},
    "friction_3d_prox,settings=tuned": ({}, {"SICONOS_FRICTION_3D_PROXIMAL_DPARAM_SIGMA": 0.5}),
    **{f"{kind}friction_3d_admm,settings=tuned": _BALANCED for kind in ("", "global_")},
    **{f"lcp_{method},settings=tuned": ({}, {}) for method in ("lemke", "pivot")},  # their q is perturbed
    "friction_3d_nsn_ac,settings=dense": ({}, {}),
}

# The kind of the problem, the scaling that converts its answer, and the problem in the message to the child.
Prepared = tuple[str, DenseLCP | ScaledDelassus, dict[str, Any]]


@solver(
    "siconos",
    family="outside",
    model="coulomb",
    dimension=(2, 3),
    warm_start=True,
    needs=(f"siconos.numerics@{PYTHON}",),
    lacks=("friction_bias",),
    remote=True,
    variants=tuple(f"method={method}" for method in (*_METHODS, *_TUNED)),
)
class Siconos:
    """Siconos' solvers of LCPs and friction problems, in a child process. (outside)

    method: Siconos' constant without SICONOS_, in small letters. settings: default, tuned, newton or dense. Work: iterations.
    """

    method: str = "friction_3d_prox"
    settings: str = "default"

    @property
    def model(self) -> Model:
        return "lcp" if self.method in _LCP else "relaxation" if self.method == "global_friction_3d_ipm" else "coulomb"

    @property
    def dimension(self) -> tuple[int, ...]:
        return (2,) if self.method in _PLANAR else (3,) if self.method in _GLOBAL else (2, 3)

    @property
    def lacks(self) -> tuple[str, ...]:
        if self.method in _GLOBAL:
            return "friction_bias", "joints", "asymmetry"
        return () if self.method in _LCP else ("friction_bias",)

    def form(self, problem: FrictionProblem | LCP) -> Prepared:
        kind = next(kind for kind in ("lcp", "friction_2d", "friction_3d", "global") if self.method.startswith(kind))
        given: DenseLCP | ScaledDelassus
        if isinstance(problem, LCP) or kind == "lcp":
            lcp = dense_lcp(problem) if "newton" in self.method else smallest_lcp(problem)
            given = perturbed(lcp) if self.settings == "tuned" else lcp
            message: dict[str, Any] = {"M": given.M, "q": given.q}
        else:
            nc = problem.contacts
            full = self.method in ("friction_3d_admm", "friction_3d_prox") and 2 * len(problem.blocks.neighbours) > nc**2
            dense = kind != "global" and (full or self.settings == "dense" or nc <= _DENSE.get(self.method, 0))
            size = 4.0 if (self.method, self.settings) in _LARGER else 1.0
            given = scaled_delassus(problem, PLANE if kind == "friction_2d" else SPACE, matrix=dense, size=size)
            W = given.W if dense else entries(*problem.blocks, given.E, given.rows)
            message = global_form(problem, given) if kind == "global" else {"dense": dense, "W": W, "q": given.q}
            message["mu"] = problem.friction
        return kind, given, message

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        kind, given, message = prepared
        integers, reals = _TUNED.get(f"{self.method},settings={self.settings}", ({}, {}))
        size = float(np.linalg.norm(given.q)) or 1.0
        asked = {
            "kind": kind,
            "solver": self.method.removesuffix("_least_index"),
            "integers": {"SICONOS_LCP_IPARAM_PIVOTING_METHOD_TYPE": 2} if self.method.endswith("_least_index") else integers,
            "reals": reals,
            "local": "FRICTION_3D_ONECONTACT_NSN" if self.settings == "newton" and (message["mu"] > 0).all() else "",
            "eps": tol * given.share / _ASKED.get(f"{self.method},settings={self.settings}", 2),
            "size": size * (2 * np.sqrt(len(message["mu"])) if kind == "friction_2d" else 1.0),
            "limit": limit or (1000 if "new" in self.method or "nsn" in self.method else 100_000),
            "start": np.zeros(len(given.q)) if start is None or isinstance(given, DenseLCP) else given.guess(start),
        }
        found = child("siconos_numerics.py", PYTHON).ask(**asked, **message)
        failed, detail = found["code"] or found["unsaid"], f"Siconos' code {found['code']}"
        status = Status.FAILED if failed else Status.SOLVED
        if isinstance(given, DenseLCP) and not found["code"]:
            status = given.status(found["r"], tol)
        scaled = given.scaled if isinstance(given, DenseLCP) else given
        return scaled.answer(found["r"], status, detail, found["clock"], iterations=found["iterations"])


def perturbed(lcp: DenseLCP) -> DenseLCP:
    """The LCP with random numbers, below 1e-10 and 1e-9 in the residual's units, added to q against ties in ratio tests."""
    most = 1e-10 * np.minimum(1.0, 10 / lcp.scaled.unit[1])
    return lcp._replace(q=lcp.q + most * np.random.default_rng(0).random(len(lcp.q)))


def global_form(problem: FrictionProblem, given: ScaledDelassus) -> dict[str, Array]:
    """M^ and H^ as entries (row, column, value), q^ (nv,) and b^ (nc*d,) of a problem without joints."""
    m, J, free = problem.mass_rows, problem.contact_rows, problem.free_velocity
    row, D = row_of_entry(m.start), 1 / np.sqrt(problem.mass.diagonal())
    entry, a = np.nonzero(J.value)
    contact, column = row_of_entry(J.start)[entry], J.column[entry]
    return {
        "M": np.column_stack([row, m.column, D[row] * m.value * D[m.column]]),
        "H": np.column_stack([column, contact * problem.dimension + a, D[column] * J.value[entry, a] * given.E[contact]]),
        "q": np.bincount(row, D[row] * m.value * free[m.column] / given.theta, len(free)),
        "b": (given.E[:, None] * problem.offset / given.theta).ravel(),
    }
