"""Siconos/Numerics in a child process: Debian's python3-siconos, for the system's Python only.

Licence: Apache-2.0. (The metadata of Debian's 4.4.0 state 4.5.0.)
Form: for lcp_ the friction LCP's M, dense and scaled; for friction_ the dimensionless Delassus matrix, dense, with a decoupled
    second tangent for friction_3d_ on planar problems; for global_, in space only, M, H = J' and q, sparse and dimensionless.
    Setup: their transfer, and Siconos' problem object. Solve: the driver's call, and some 50 µs of transfer.
Clock: around the driver's call, in the child.
Tolerance: eps/2 over |q^|, as Siconos divides the norm of its natural map by |q|; eps as in solvers.outside.scaled_delassus.
    Where |r^| is larger it divides by that, and is called again from its own answer with a smaller tolerance.
Flaws: return codes are unreliable in both directions, `frictionbench solve 'pyramid[rows=3,friction=0.5,push=1]' --solver
    'siconos[method=friction_2d_lemke]'`. friction_3d_nsn_fb and global_friction_3d_ipm end in failed assertions, and
    the fixed points (aclmfp, tfp) take minutes on difficult problems and are then stopped at the time limit.
Reference: Acary, Brémond and Huber 2018; Acary, Bonnefon, Brémond, Huber, Pérignon and Sinclair 2019, Siconos.
"""

from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.solvers.interface import Answer, Model, Status, impulses, solver
from frictionbench.solvers.outside.children.child import child
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus, scaled_delassus
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

PYTHON = "/usr/bin/python3"
_LCP = ("lcp_lemke", "lcp_pivot", "lcp_newton_fb_fblsa", "lcp_newton_min_fblsa")
_PLANAR = ("friction_2d_nsgs", "friction_2d_cpg", "friction_2d_lemke")
_SPATIAL = tuple(f"friction_3d_{name}" for name in ("nsgs", "prox", "admm", "nsn_ac", "nsn_fb", "aclmfp", "tfp", "dsfp"))
_GLOBAL = ("global_friction_3d_admm", "global_friction_3d_ipm")
_METHODS = (*_LCP, *_PLANAR, *_SPATIAL, *_GLOBAL)
_SCRIPT = "siconos_numerics.py"


class Prepared(NamedTuple):
    """The message to the child, and the scaling that converts its answer."""

    kind: str
    given: DenseLCP | ScaledDelassus
    message: dict[str, Any]


@solver(
    "siconos",
    family="outside",
    model="coulomb",
    dimension=(2, 3),
    warm_start=True,
    needs=(f"siconos.numerics@{PYTHON}",),
    lacks=("friction_bias",),
    variants=tuple(f"method={method}" for method in _METHODS),
)
class Siconos:
    """Siconos' solvers of LCPs and friction problems, in a child process. (outside)

    method: the name of Siconos' constant without SICONOS_, in small letters. Work: iterations.
    """

    method: str = "friction_3d_prox"

    def __post_init__(self) -> None:
        require(self.method in _METHODS, "method", f"must be one of {', '.join(_METHODS)}, got {self.method!r}")

    @property
    def model(self) -> Model:
        return "lcp" if self.method in _LCP else "relaxation" if self.method == "global_friction_3d_ipm" else "coulomb"

    @property
    def dimension(self) -> tuple[int, ...]:
        return (2,) if self.method in _PLANAR else (3,) if self.method in _GLOBAL else (2, 3)

    @property
    def lacks(self) -> tuple[str, ...]:
        return () if self.method in _LCP else ("friction_bias", "joints") if self.method in _GLOBAL else ("friction_bias",)

    def form(self, problem: FrictionProblem | LCP) -> Prepared:
        kind = next(kind for kind in ("lcp", "friction_2d", "friction_3d", "global") if self.method.startswith(kind))
        given: DenseLCP | ScaledDelassus
        if isinstance(problem, LCP) or kind == "lcp":
            given = dense_lcp(problem)
            message: dict[str, Any] = {"M": given.M, "q": given.q}
        else:
            given = scaled_delassus(problem)
            W, q = (given.W.toarray(), given.q) if kind == "friction_2d" else given.in_space()
            message = _global(problem, given) if kind == "global" else {"W": W, "q": q}
            message["mu"] = problem.friction
        return Prepared(kind, given, message)

    def setup(self, formed: Prepared) -> Prepared:
        if len(formed.given.q):
            child(_SCRIPT, PYTHON).store(formed, kind=formed.kind, **formed.message)
        return formed

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        given, message = prepared.given, prepared.message
        if not len(given.q):
            z = np.zeros(0)
            return given.answer(z, Status.SOLVED) if isinstance(given, DenseLCP) else Answer(given.impulse(z), Status.SOLVED)
        self.setup(prepared)
        size = len(message["b" if prepared.kind == "global" else "q"])
        eps = tol if isinstance(given, DenseLCP) else tol * given.share
        guess = np.zeros(size)
        if start is not None and isinstance(given, ScaledDelassus):
            start = impulses(start, given.contacts)
            own = start.ravel() / (given.theta * given.E)
            guess = given.to_space(start) if size == 3 * len(start) else own
        most = limit or (1000 if "new" in self.method or "nsn" in self.method else 100_000)
        norm = float(np.linalg.norm(given.q)) or 1.0
        found = child(_SCRIPT, PYTHON).ask(solver=self.method, eps=eps / 2, size=norm, limit=most, start=guess)
        status, detail = (Status.FAILED if found["code"] else Status.SOLVED), f"Siconos' code {found['code']}"
        work, r = {"iterations": found["iterations"]}, found["r"]
        if isinstance(given, DenseLCP):
            return given.answer(r, status, detail, found["clock"], **work)
        impulse = given.from_space(r) if size == 3 * len(given.friction) else given.impulse(r)
        return Answer(impulse, status, work, detail=detail, clock=found["clock"])


def _global(problem: FrictionProblem, given: ScaledDelassus) -> dict[str, Array]:
    """M v = H r + q, u = H'v + b in pure numbers: v = theta D v^ with D = 1/sqrt(M_ii)."""
    D = 1 / np.sqrt(problem.mass.diagonal())
    H = (problem.jacobian.multiply(given.E[:, None]).multiply(D)).toarray().T
    M, q = problem.mass.toarray() * D * D[:, None], D * (problem.mass @ problem.free_velocity) / given.theta
    return {"M": M, "H": H, "q": q, "b": given.E * problem.offset.ravel() / given.theta}
