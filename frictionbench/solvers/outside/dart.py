"""DART's solvers of boxed LCPs with friction indices, from version 7 on: the planar friction problem itself.

    w = A x - b,    lo <= x <= hi complementary to w,    |x_t| <= mu x_n for a row t whose findex names row n

With A = W and b = -q this is Coulomb's law in the plane, without the additional unknowns of the LCP. In space the
box differs from Coulomb's cone.

Licence: BSD-2-Clause.
Form: the dimensionless Delassus matrix, dense; bounds and friction indices. Setup: DART's LcpProblem. Solve: a solver object
    and its solve, from x = 0.
Clock: none.
Settings: its defaults.
Tolerance: absolute and complementarity tolerance of eps/10, eps as in solvers.outside.scaled_delassus; the relative one is off.
Flaws: untested: no version 7 can be installed from the package index. 6.20 has no LcpProblem, and its BoxedLcpSolver binds
    pointers as scalars. The calls follow DART's tests of its Python interface.
Reference: Lee and others 2018, DART; Baraff 1994 and Smith's ODE for the Dantzig solver.
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.margin import MARGIN
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus, scaled_delassus

_METHODS = {"dantzig": "DantzigSolver", "newton": "BoxedSemiSmoothNewtonSolver", "pgs": "PgsSolver", "nncg": "NncgSolver"}


class Prepared(NamedTuple):
    given: ScaledDelassus
    problem: Any  # dartpy.LcpProblem


@solver(
    "dart",
    family="outside",
    model="coulomb",
    needs=("dartpy>=7",),
    lacks=("friction_bias",),
    variants=tuple(f"method={method}" for method in _METHODS),
)
class Dart:
    """DART's solvers of boxed LCPs with friction indices: Dantzig, semismooth Newton, PGS, NNCG. (outside)

    method: dantzig, newton, pgs or nncg. Work: iterations.
    """

    method: str = "dantzig"

    def __post_init__(self) -> None:
        require(self.method in _METHODS, "method", f"must be one of {', '.join(_METHODS)}, got {self.method!r}")

    def form(self, problem: FrictionProblem) -> tuple[ScaledDelassus, tuple[Any, ...]]:
        given, normal = scaled_delassus(problem), 2 * np.arange(problem.contacts)
        hi, findex = np.full(len(given.q), np.inf), np.full(len(given.q), -1, dtype=np.int32)
        hi[1::2], findex[1::2] = given.friction, normal
        lo = np.where(findex < 0, 0.0, -hi)
        return given, (given.W, -given.q, lo, hi, findex)

    def setup(self, formed: tuple[ScaledDelassus, tuple[Any, ...]]) -> Prepared:
        dart: Any = import_module("dartpy")
        given, parts = formed
        return Prepared(given, dart.LcpProblem(*parts))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        dart: Any = import_module("dartpy")
        given, options = prepared.given, dart.LcpOptions()
        if not len(given.q):
            return Answer(np.zeros(given.contacts), Status.SOLVED)
        options.absolute_tolerance = options.complementarity_tolerance = given.share * tol / MARGIN
        options.relative_tolerance, options.max_iterations = 0.0, limit or 20_000
        result, x = getattr(dart, _METHODS[self.method])().solve(prepared.problem, options=options)
        status = Status.SOLVED if result.succeeded() else Status.FAILED
        return Answer(given.impulse(x), status, {"iterations": int(result.iterations)}, detail=str(result.message))
