"""The convex relaxation in the plane by OSQP's own Python interface, as a simulator uses it.

Licence: Apache-2.0.
Form: the dimensionless QP (solvers.outside.scaled_program), G and A stacked, P's upper half. Setup: OSQP's setup; with
    keep=true an update of the workspace of the previous step, if the sparsity pattern is the same. Solve: its solve.
Clock: OSQP's own solve_time.
Settings: its defaults.
Tolerance: eps_abs = eps/10 for both residuals and the gap, eps_rel = 0, not polished; eps stands for tol.
Flaws: another model than Coulomb's wherever boxes slide, `frictionbench solve stopping_block --solver osqp`.
Reference: Stellato, Banjac, Goulart, Bemporad and Boyd 2020.
"""

from functools import cached_property
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.relaxation import QP
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.margin import MARGIN
from frictionbench.solvers.outside.reused_object import ReusedObject
from frictionbench.solvers.outside.scaled_program import ScaledProgram, scaled_program


class Formed(NamedTuple):
    """OSQP's P, A and bounds besides the scaled program."""

    scaled: ScaledProgram[QP]
    P: sparse.csc_matrix
    A: sparse.csc_matrix
    lower: Array
    upper: Array


class Prepared(NamedTuple):
    scaled: ScaledProgram[QP]
    workspace: Any


@solver(
    "osqp",
    family="relaxation",
    model="relaxation",
    warm_start=True,
    sparse=True,
    needs=("osqp",),
    lacks=("asymmetry",),
    variants=("keep=false", "keep=true"),
)
class OSQP:
    """The convex relaxation as a QP by OSQP itself. (outside)

    keep: update the workspace of the previous problem instead of setting up another. Work: iterations.
    """

    keep: bool = False

    @cached_property
    def _reused(self) -> ReusedObject:
        return ReusedObject()

    def form(self, problem: FrictionProblem) -> Formed:
        scaled = scaled_program(problem, problem.qp())
        lower, upper = np.concatenate([np.full(len(scaled.h), -np.inf), scaled.b]), np.concatenate([scaled.h, scaled.b])
        return Formed(scaled, scaled.upper, scaled.constraints, lower, upper)

    def setup(self, formed: Formed) -> Prepared:
        osqp: Any = import_module("osqp")
        scaled, P, A, lower, upper = formed

        def make() -> Any:
            workspace = osqp.OSQP()
            workspace.setup(P, scaled.q, A, lower, upper, verbose=False, eps_rel=0.0)
            return workspace

        def update(workspace: Any) -> None:
            workspace.update(q=scaled.q, l=lower, u=upper, Px=P.data, Ax=A.data)
            workspace.update_settings(rho=0.1)  # the initial value: OSQP adapts it

        return Prepared(scaled, self._reused.get(scaled.pattern(), make, update) if self.keep else make())

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        scaled, workspace = prepared
        if not scaled.program.contacts[0]:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        workspace.update_settings(eps_abs=tol * scaled.share / MARGIN, max_iter=limit or 100_000)
        x, y = np.zeros(len(scaled.q)), np.zeros(len(scaled.h) + len(scaled.b))
        if start is not None:
            y[: len(scaled.h)] = scaled.multipliers(start)
            x = sparse.linalg.spsolve(scaled.P, -scaled.q - scaled.G.T @ y[: len(scaled.h)]) if not len(scaled.b) else x
        workspace.warm_start(x=x, y=y)
        found = workspace.solve(raise_error=False)
        z, status = found.y[: len(scaled.h)], Status.SOLVED if found.info.status_val == 1 else Status.FAILED
        work = {"iterations": int(found.info.iter)}
        return Answer(scaled.impulse(z), status, work, detail=found.info.status, clock=found.info.solve_time)
