"""Drake's two solvers of LCPs: MobyLcp, a Lemke method with retries, and UnrevisedLemke.

Licence: BSD-3-Clause; the wheel bundles proprietary libraries that none of these solvers calls.
Form: the friction LCP's M, dense and scaled, and q. Setup: a MathematicalProgram with that one constraint. Solve: a new solver
    object, as a reused one starts from its last basis, and its Solve.
Clock: none.
Tolerance: it takes none; both check their solutions against zero tolerances of their own, which are left at their defaults.
Flaws: with large mass ratios UnrevisedLemke fails and MobyLcp reports success for wrong answers, `frictionbench solve
    'stack[blocks=5,mass_ratio=1e4,push=1]' --solver 'drake[method=unrevised]' --solver 'drake[method=moby]'`. MobyLcp takes
    seconds from 100 contacts on.
Reference: Drewniak, Tedrake and others, Drake; Dai and Drumwright, "Computing the Principal Pivoting Transform"
(UnrevisedLemke).
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

_METHODS = {"moby": "MobyLcpSolver", "unrevised": "UnrevisedLemkeSolver"}


class Prepared(NamedTuple):
    given: DenseLCP
    program: Any
    z: Any


@solver(
    "drake",
    family="pivoting",
    model="lcp",
    dimension=(2, 3),
    needs=("drake",),
    variants=tuple(f"method={method}" for method in _METHODS),
)
class Drake:
    """Drake's solvers of LCPs: MobyLcp or UnrevisedLemke. (outside)

    method: moby or unrevised. Work: none is reported.
    """

    method: str = "moby"

    def __post_init__(self) -> None:
        require(self.method in _METHODS, "method", f"must be one of {', '.join(_METHODS)}, got {self.method!r}")

    def form(self, problem: FrictionProblem | LCP) -> DenseLCP:
        return dense_lcp(problem)

    def setup(self, given: DenseLCP) -> Prepared:
        drake: Any = import_module("pydrake.solvers")
        program = drake.MathematicalProgram()
        z = program.NewContinuousVariables(len(given.q))
        program.AddLinearComplementarityConstraint(given.M, given.q, z)
        return Prepared(given, program, z)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        drake: Any = import_module("pydrake.solvers")
        if not len(prepared.given.q):
            return prepared.given.answer(np.zeros(0), Status.SOLVED)
        found = getattr(drake, _METHODS[self.method])().Solve(prepared.program, None, None)
        status = Status.SOLVED if found.is_success() else Status.FAILED
        return prepared.given.answer(found.GetSolution(prepared.z), status, found.get_solution_result().name)
