"""Drake's two solvers of LCPs: MobyLcp, a Lemke method with retries, and UnrevisedLemke.

MobyLcp's retries regularise: its answers are those of M + lambda I, lambda up to 1e-4 at least (SolveLcpLemkeRegularized), and
differ from the LCP's accordingly.

Licence: BSD-3-Clause; the wheel bundles proprietary libraries that none of these solvers calls.
Form: the friction LCP's M, dense and scaled, and q. Setup: a MathematicalProgram with that one constraint. Solve: a new solver
    object, as a reused one starts from its last basis, and its Solve.
Clock: none.
Settings: its defaults; there are no options. With perturbation=1e-10 the LCP is given q + 1e-10 rand, as its ratio test has no
    rule for ties; our lemke perturbs, too, `frictionbench solve 'stack[blocks=50,friction=0.05,push=1]' --solver
    'drake[method=unrevised]' --solver 'drake[method=unrevised,perturbation=1e-10]'`.
Tolerance: it takes none; both check their solutions against zero tolerances of their own, which are left at their defaults.
Flaws: with large mass ratios UnrevisedLemke fails and MobyLcp, regularised, reports success for inexact answers,
    `frictionbench solve 'stack[blocks=5,mass_ratio=1e4,push=1]' --solver 'drake[method=unrevised]' --solver
    'drake[method=moby]'`.
Reference: Drewniak, Tedrake and others, Drake; Dai and Drumwright, "Computing the Principal Pivoting Transform"
    (UnrevisedLemke).
"""

from importlib import import_module
from typing import Any

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

_METHODS = {"moby": "MobyLcpSolver", "unrevised": "UnrevisedLemkeSolver"}


@solver(
    "drake",
    family="pivoting",
    model="lcp",
    dimension=(2, 3),
    needs=("drake",),
    variants=("method=moby", "method=unrevised", "method=unrevised,perturbation=1e-10"),
)
class Drake:
    """Drake's solvers of LCPs: MobyLcp or UnrevisedLemke. (outside)

    method: moby or unrevised. perturbation: the size of random numbers that are added to q, which is of size 1.
    Work: none is reported.
    """

    method: str = "moby"
    perturbation: float = 0.0

    def __post_init__(self) -> None:
        require(0 <= self.perturbation < 1, "perturbation", f"must be at least 0 and less than 1, got {self.perturbation!r}")

    def form(self, problem: FrictionProblem | LCP) -> DenseLCP:
        given = dense_lcp(problem)
        if not self.perturbation:
            return given
        return given._replace(q=given.q + self.perturbation * np.random.default_rng(0).random(len(given.q)))

    def setup(self, given: DenseLCP) -> tuple[DenseLCP, Any, Any]:
        drake: Any = import_module("pydrake.solvers")
        program = drake.MathematicalProgram()
        z = program.NewContinuousVariables(len(given.q))
        program.AddLinearComplementarityConstraint(given.M, given.q, z)
        return given, program, z

    def solve(self, prepared: tuple[DenseLCP, Any, Any], tol: float, limit: int | None, start: Array | None = None) -> Answer:
        drake: Any = import_module("pydrake.solvers")
        given, program, z = prepared
        found = getattr(drake, _METHODS[self.method])().Solve(program, None, None)
        status = Status.SOLVED if found.is_success() else Status.FAILED
        return given.scaled.answer(found.GetSolution(z), status, found.get_solution_result().name)
