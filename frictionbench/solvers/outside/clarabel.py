"""The convex relaxation by Clarabel's own Python interface: linear constraints in the plane, circular cones in space.

Licence: Apache-2.0.
Form: the dimensionless program (solvers.outside.scaled_program), A and G stacked, P's upper half. Setup: Clarabel's solver
    object, its ordering and scaling; with keep=true an update of the object of the previous step, if the sparsity pattern is
    the same. Solve: its solve. (It has no warm start.)
Clock: its solve_time, which includes its setup, also where the object was kept.
Settings: presolve off, which would forbid updates. tuned is for programs that are already scaled, as these are:
    equilibrate_enable off, static_regularization_constant = 1e-12 instead of 1e-8, and iterative_refinement_abstol and
    iterative_refinement_reltol 1e-16 instead of 1e-12 and 1e-13, `frictionbench solve 'two_corner_block[fall=1]' --solver
    'clarabel' --solver 'clarabel[settings=tuned]'`.
Tolerance: tol_feas = eps, both gaps eps^2, no less than 1e-16; eps stands for tol.
Flaws: its gap is the difference of two objectives, which rounding can make 0 before the answer is accurate: some answers that
    it calls Solved are off by a few times 1e-8. Or it stays above eps^2, and it reports failure although the answer is
    accurate, `frictionbench solve 'random_bodies[seed=0,contacts=4]' --solver clarabel`.
Reference: Goulart and Chen 2024.
"""

from functools import cached_property
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.relaxation import QP, ConeProgram
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.reused_object import ReusedObject
from frictionbench.solvers.outside.scaled_program import ScaledProgram, gap_tolerance, scaled_program
from frictionbench.solvers.outside.settings import require_settings

LEAST_GAP = 1e-16  # with 1e-15 errors of 7e-8 remain in closed loop, and below 1e-16 it seldom reports success
_TUNED = {
    "equilibrate_enable": False,
    "static_regularization_constant": 1e-12,
    "iterative_refinement_abstol": 1e-16,
    "iterative_refinement_reltol": 1e-16,
}
Scaled = ScaledProgram[QP] | ScaledProgram[ConeProgram]


class Formed(NamedTuple):
    """Clarabel's P, A and b besides the scaled program."""

    scaled: Scaled
    P: sparse.csc_matrix
    A: sparse.csc_matrix
    b: Array


class Prepared(NamedTuple):
    scaled: Scaled
    object: Any


@solver(
    "clarabel",
    family="relaxation",
    model="relaxation",
    dimension=(2, 3),
    sparse=True,
    needs=("clarabel",),
    lacks=("asymmetry",),
    variants=("keep=false", "keep=false,settings=tuned", "keep=true"),
)
class Clarabel:
    """The convex relaxation by Clarabel itself, with circular cones in space. (outside)

    keep: update the object of the previous problem instead of creating another. settings: default or tuned.
    Work: iterations.
    """

    keep: bool = False
    settings: str = "default"

    def __post_init__(self) -> None:
        require_settings(self.settings)

    @cached_property
    def _reused(self) -> ReusedObject:
        return ReusedObject()

    def form(self, problem: FrictionProblem) -> Formed:
        if problem.dimension == 2:
            scaled: Scaled = scaled_program(problem, problem.qp(), from_free=True)
        else:
            scaled = scaled_program(problem, problem.cone(), from_free=True)
        return Formed(scaled, scaled.upper, scaled.constraints, np.concatenate([scaled.h, scaled.b]))

    def setup(self, formed: Formed) -> Prepared:
        clarabel: Any = import_module("clarabel")
        scaled, P, A, b = formed
        if not scaled.program.contacts[0]:
            return Prepared(scaled, None)
        cones = [clarabel.NonnegativeConeT(len(scaled.h))]
        if isinstance(scaled.program, ConeProgram):
            cones = [clarabel.SecondOrderConeT(3)] * (len(scaled.h) // 3)
        cones, q = [*cones, clarabel.ZeroConeT(len(scaled.b))] if len(scaled.b) else cones, scaled.q

        def make() -> Any:
            return clarabel.DefaultSolver(P, q, A, b, cones, self._settings())

        def update(made: Any) -> None:
            made.update(P=P, q=q, A=A, b=b)

        return Prepared(scaled, self._reused.get(scaled.pattern(), make, update) if self.keep else make())

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        clarabel: Any = import_module("clarabel")
        scaled, made = prepared
        if made is None:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        eps = tol * scaled.share
        gap = gap_tolerance(eps, LEAST_GAP)
        made.update(settings=self._settings(tol_feas=eps, tol_gap_abs=gap, tol_gap_rel=gap, max_iter=limit or 200))
        found = made.solve()
        z = np.array(found.z)[: len(scaled.h)]
        status = Status.SOLVED if found.status == clarabel.SolverStatus.Solved else Status.FAILED
        return Answer(
            scaled.impulse(z), status, {"iterations": found.iterations}, detail=str(found.status), clock=found.solve_time
        )

    def _settings(self, **chosen: Any) -> Any:
        """Clarabel's settings: quiet, and without the presolve that would forbid updates."""
        settings = import_module("clarabel").DefaultSettings()
        tuned = _TUNED if self.settings == "tuned" else {}
        for name, value in {"verbose": False, "presolve_enable": False, **tuned, **chosen}.items():
            setattr(settings, name, value)
        return settings
