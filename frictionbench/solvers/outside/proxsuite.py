"""The convex relaxation in the plane by ProxSuite's own Python interface, as a simulator uses it.

Licence: BSD-2-Clause.
Form: the dimensionless QP (solvers.outside.scaled_program), sparse or dense. Setup: the QP object and its init; with keep=true
    an update of the object of the previous step, if the sparsity pattern is the same. Solve: its solve.
Clock: ProxQP's own solve_time.
Settings: compute_timings and check_duality_gap on. By default eps_primal_inf = eps_dual_inf = 1e-4, with which it calls
    solvable problems infeasible; tuned are 1e-14, `frictionbench solve 'stack[blocks=10,mass_ratio=10000]' --solver 'proxsuite'
    --solver 'proxsuite[settings=tuned]'`.
Tolerance: eps_abs = eps for both residuals, gap eps^2, no less than 1e-14, which is tested only on request; eps_rel = 0; eps
    stands for tol.
Flaws: another model than Coulomb's wherever boxes slide, `frictionbench solve stopping_block --solver proxsuite`.
Reference: Bambade, El-Kazdadi, Taylor and Carpentier 2022.
"""

from functools import cached_property
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.problems.forms.relaxation import QP
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.reused_object import ReusedObject
from frictionbench.solvers.outside.scaled_program import ScaledProgram, gap_tolerance, scaled_program
from frictionbench.solvers.outside.settings import require_settings

LEAST_GAP = 1e-14
TUNED_INFEASIBILITY = 1e-14


class Formed(NamedTuple):
    """ProxQP's P, q, A, b, G, l and u besides the scaled program."""

    scaled: ScaledProgram[QP]
    parts: tuple[Any, ...]


class Prepared(NamedTuple):
    scaled: ScaledProgram[QP]
    qp: Any


@solver(
    "proxsuite",
    family="relaxation",
    model="relaxation",
    warm_start=True,
    sparse=True,
    needs=("proxsuite",),
    lacks=("asymmetry",),
    variants=tuple(
        f"{variant}{settings}"
        for variant in ("matrices=sparse", "matrices=dense", "matrices=sparse,keep=true")
        for settings in ("", ",settings=tuned")
    ),
)
class ProxSuite:
    """The convex relaxation as a QP by ProxSuite itself. (outside)

    matrices: sparse or dense. keep: update the object of the previous problem instead of creating another.
    settings: default or tuned. Work: iterations.
    """

    matrices: str = "sparse"
    keep: bool = False
    settings: str = "default"

    def __post_init__(self) -> None:
        require(self.matrices in ("sparse", "dense"), "matrices", f"must be sparse or dense, got {self.matrices!r}")
        require_settings(self.settings)

    @cached_property
    def _reused(self) -> ReusedObject:
        return ReusedObject()

    def form(self, problem: FrictionProblem) -> Formed:
        scaled = scaled_program(problem, problem.qp(), from_free=True)
        P, G, A = (scaled.P, scaled.G, scaled.A) if self.matrices == "sparse" else scaled.dense
        equality = (A, scaled.b) if len(scaled.b) else (None, None)
        return Formed(scaled, (P, scaled.q, *equality, G, np.full(len(scaled.h), -1e20), scaled.h))

    def setup(self, formed: Formed) -> Prepared:
        proxqp: Any = import_module("proxsuite").proxqp
        scaled, parts = formed

        def make() -> Any:
            qp = getattr(proxqp, self.matrices).QP(len(scaled.q), len(scaled.b), len(scaled.h))
            qp.settings.compute_timings = True
            qp.init(*parts)
            return qp

        def update(qp: Any) -> None:
            qp.update(*parts, update_preconditioner=True)

        return Prepared(scaled, self._reused.get(scaled.pattern(), make, update) if self.keep else make())

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        proxqp: Any = import_module("proxsuite").proxqp
        scaled, qp = prepared
        if not scaled.program.contacts[0]:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        eps, settings = tol * scaled.share, qp.settings
        settings.eps_abs, settings.eps_rel, settings.max_iter = eps, 0.0, limit or 10_000
        settings.check_duality_gap, settings.eps_duality_gap_rel = True, 0.0
        settings.eps_duality_gap_abs = gap_tolerance(eps, LEAST_GAP)
        if self.settings == "tuned":
            settings.eps_primal_inf = settings.eps_dual_inf = TUNED_INFEASIBILITY
        if start is None:
            settings.initial_guess = proxqp.InitialGuess.NO_INITIAL_GUESS
            qp.solve()
        else:
            settings.initial_guess = proxqp.InitialGuess.WARM_START
            qp.solve(np.zeros(len(scaled.q)), np.zeros(len(scaled.b)), scaled.multipliers(start))
        info, z = qp.results.info, np.array(qp.results.z)
        status = Status.SOLVED if info.status == proxqp.QPSolverOutput.PROXQP_SOLVED else Status.FAILED
        return Answer(
            scaled.impulse(z), status, {"iterations": info.iter}, detail=info.status.name, clock=info.solve_time * 1e-6
        )
