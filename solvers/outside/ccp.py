"""The convex relaxation as a quadratic program, by an outside library through qpsolvers.

Planar problems only, where the cones are polygons; `ccp_cone` takes round ones too. It is another model than Coulomb's: see
problems.forms.relaxation.

The program is scaled to pure numbers (solvers.outside.scaled_program), so that eps below stands for tol in the project's
measure:

    clarabel   interior point. tol_feas = eps for the primal and dual residuals, tol_gap_abs = tol_gap_rel = eps^2.
    proxqp     augmented Lagrangian. eps_abs = eps for both residuals, eps_duality_gap_abs = eps^2: it does not test the gap
               unless told to, and complementarity is then left open.
    osqp       ADMM. eps_abs = eps/10 for both residuals and the gap, eps_rel = 0, not polished.

References: Anitescu 2006 for the model; Goulart and Chen 2024 (Clarabel); Stellato and others 2020 (OSQP); Bambade and others
2022 (ProxQP).
"""

import warnings
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from problems import FrictionProblem
from problems.check import Array, require
from problems.forms.relaxation import QP
from solvers.interface import Answer, Status, solver
from solvers.outside.scaled_program import ScaledProgram, gap_tolerance, scaled_program

_LIMIT = {"clarabel": 200, "osqp": 100_000, "proxqp": 10_000}  # iterations, by backend


@dataclass(frozen=True, eq=False)
class Prepared:
    scaled: ScaledProgram[QP]
    problem: Any  # qpsolvers.Problem


@solver("ccp", family="relaxation", model="relaxation", sparse=True, needs=("qpsolvers", "clarabel", "osqp", "proxsuite"))
class CCP:
    """The convex relaxation as a QP in the velocities, by Clarabel, OSQP or ProxQP.

    backend: clarabel, osqp or proxqp. Work: the backend's iterations, where it reveals them.
    """

    backend: str = "clarabel"

    def __post_init__(self) -> None:
        require(self.backend in _LIMIT, "backend", f"must be one of {', '.join(_LIMIT)}, got {self.backend!r}")

    def form(self, problem: FrictionProblem) -> ScaledProgram[QP]:
        return scaled_program(problem, problem.qp())

    def setup(self, scaled: ScaledProgram[QP]) -> Prepared:
        qpsolvers: Any = import_module("qpsolvers")

        joints = (scaled.A, scaled.b) if scaled.A is not None else (None, None)
        return Prepared(scaled, qpsolvers.Problem(scaled.P, scaled.q, scaled.G, scaled.h, *joints))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        qpsolvers: Any = import_module("qpsolvers")

        scaled = prepared.scaled
        if not scaled.program.contacts[0]:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        settings = self._settings(tol * scaled.share)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # qpsolvers' word on a failure; it is in the status
            found = qpsolvers.solve_problem(prepared.problem, self.backend, max_iter=limit or _LIMIT[self.backend], **settings)
        info = found.extras.get("info")
        status = Status.SOLVED if found.found else Status.FAILED
        return Answer(
            scaled.impulse(found.z),
            status,
            {} if info is None else {"iterations": int(info.iter)},
            detail=str(found.extras["status"] if info is None else info.status),
        )

    def _settings(self, eps: float) -> dict[str, float]:
        gap = gap_tolerance(eps, round_cones=False)
        if self.backend == "clarabel":
            return {"tol_feas": eps, "tol_gap_abs": gap, "tol_gap_rel": gap}
        if self.backend == "proxqp":
            return {
                "eps_abs": eps,
                "eps_rel": 0.0,
                "check_duality_gap": True,
                "eps_duality_gap_abs": gap,
                "eps_duality_gap_rel": 0.0,
            }
        return {"eps_abs": eps / 10, "eps_rel": 0.0}
