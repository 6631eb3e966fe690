"""The convex relaxation as a quadratic program, solved by an outside library through qpsolvers.

Planar problems only, where the cones are polyhedral; `ccp_cone` also takes circular ones. The relaxation differs from Coulomb's
law: see problems.forms.relaxation.

Libraries with an adapter that calls them directly are here only where suites compare them in this form, without objects of
their own.

Licence: qpsolvers LGPL-3.0; Clarabel and OSQP Apache-2.0, ProxSuite BSD-2-Clause, HiGHS and SCS MIT, ECOS GPL-3.0, QPALM
    LGPL-3.0-or-later.
Form: the dimensionless QP (solvers.outside.scaled_program), dense for ECOS. Setup: qpsolvers' problem. Solve: qpsolvers' call,
    the backend's own setup inside.
Clock: qpsolvers', around the backend's solve, after its setup where the two can be separated.
Settings: for highs qp_regularization_value is 1e-7 by default; tuned is 0. ProxQP's eps_primal_inf and eps_dual_inf, which make
    it call solvable problems infeasible, cannot be set through qpsolvers; the solver proxsuite sets them.
Tolerance: eps is tol in the units of the scaled program; complementarity requires a gap of eps^2, of which ProxQP and ECOS
    reach 1e-14 and Clarabel 1e-16. clarabel tol_feas = eps, gaps eps^2. osqp eps_abs = eps/10, not polished. proxqp eps_abs =
    eps, gap eps^2, which it tests only on request. highs both feasibilities eps/10, no less than 1e-10. scs and qpalm eps_abs =
    eps/10. ecos feastol = eps/10, gaps eps^2. Relative tolerances are 0.
Flaws: the model differs from Coulomb's law wherever boxes slide, `frictionbench solve stopping_block --solver
    'ccp[backend=osqp]'`; this is due to the relaxation, not to the libraries. ECOS requires a definite matrix and so does not
    support friction_bias. HiGHS' least feasibility of 1e-10 and ECOS' arithmetic leave the residual of some answers
    at a few times 1e-8.
Reference: Anitescu 2006 for the model; Caron and others, qpsolvers; Goulart and Chen 2024 (Clarabel); Stellato and others 2020
    (OSQP); Bambade and others 2022 (ProxQP).
"""

import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, solver
from frictionbench.solvers.outside import MARGIN
from frictionbench.solvers.outside.qp_libraries import LEAST_GAP
from frictionbench.solvers.outside.scaled_program import Prepared, RelaxationSolver, gap_tolerance, scaled_program


class Backend(NamedTuple):
    """A backend's distribution, and the name and default of its limit on iterations.

    definite: whether it is given dense matrices and requires a definite P, which excludes friction_bias, whose variable has no
    weight.
    """

    distribution: str
    limit: str
    most: int
    definite: bool = False


BACKENDS = {
    "clarabel": Backend("clarabel", "max_iter", 200),
    "osqp": Backend("osqp", "max_iter", 100_000),
    "proxqp": Backend("proxsuite", "max_iter", 10_000),
    "highs": Backend("highspy", "qp_iteration_limit", 100_000),
    "scs": Backend("scs", "max_iters", 100_000),
    "ecos": Backend("ecos", "max_iters", 200, definite=True),
    "qpalm": Backend("qpalm", "max_iter", 10_000),
}


_BY_GAP = ("clarabel", "proxqp", "ecos")  # backends that stop by a duality gap
_TUNED: dict[str, dict[str, float]] = {"highs": {"qp_regularization_value": 0.0}}
_VARIANTS = (*(f"backend={name}" for name in BACKENDS), *(f"backend={name},settings=tuned" for name in _TUNED))


@solver("ccp", family="relaxation", model="relaxation", sparse=True, needs=("qpsolvers", "clarabel"), variants=_VARIANTS)
class CCP(RelaxationSolver):
    """The convex relaxation as a QP in the velocities, by a library through qpsolvers.

    backend: which library. settings: default or tuned. Work: the backend's iterations, where it reports them.
    """

    backend: str = "clarabel"
    settings: str = "default"

    @property
    def needs(self) -> tuple[str, ...]:
        return "qpsolvers", BACKENDS[self.backend].distribution

    @property
    def lacks(self) -> tuple[str, ...]:
        return ("friction_bias", "asymmetry") if BACKENDS[self.backend].definite else ("asymmetry",)

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, problem.qp(), from_free=self.backend in _BY_GAP)
        P, G, A = scaled.dense if BACKENDS[self.backend].definite else (scaled.P, scaled.G, scaled.A)
        return Prepared(scaled, (P, scaled.q, G, scaled.h, *((A, scaled.b) if len(scaled.b) else (None, None))))

    def create(self, formed: Prepared) -> Any:
        return import_module("qpsolvers").Problem(*formed.given)

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        qpsolvers: Any = import_module("qpsolvers")
        scaled, backend = prepared.scaled, BACKENDS[self.backend]
        settings = _settings(self.backend, eps) | (_TUNED[self.backend] if self.settings == "tuned" else {})
        settings |= {backend.limit: limit or backend.most}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # qpsolvers warns of a failure; the status reports it
            found = qpsolvers.solve_problem(prepared.given, self.backend, **settings)
        return scaled.answer(found.z, found.found, *_iterations_and_detail(found.extras), found.solve_time)


def _settings(backend: str, eps: float) -> dict[str, Any]:
    gap = gap_tolerance(eps, LEAST_GAP.get(backend, LEAST_GAP["proxsuite"]))
    of_proxqp = {"eps_abs": eps, "eps_rel": 0.0, "check_duality_gap": True}
    others = {name: {"eps_abs": eps / MARGIN, "eps_rel": 0.0} for name in ("osqp", "scs", "qpalm")}
    return {
        "clarabel": {"tol_feas": eps, "tol_gap_abs": gap, "tol_gap_rel": gap},
        "proxqp": of_proxqp | {"eps_duality_gap_abs": gap, "eps_duality_gap_rel": 0.0},
        "highs": dict.fromkeys(("primal_feasibility_tolerance", "dual_feasibility_tolerance"), max(eps / MARGIN, 1e-10)),
        "ecos": {"feastol": eps / MARGIN, "abstol": gap, "reltol": gap},
        **others,
    }[backend]


def _iterations_and_detail(extras: Mapping[str, Any]) -> tuple[int | None, str]:
    """The iterations and the final status of a backend, each if it reports them."""
    info = extras.get("info", extras)
    if not isinstance(info, Mapping):
        info = {name: getattr(info, name) for name in ("iter", "status") if hasattr(info, name)}
    count = info.get("iter", np.ravel(info.get("iterations", []))[:1].tolist())
    iterations = None if count == [] else int(count[0] if isinstance(count, list) else count)
    return iterations, str(info.get("status", info.get("infostring", "")))
