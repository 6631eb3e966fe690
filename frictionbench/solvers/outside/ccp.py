"""The convex relaxation as a quadratic program, solved by an outside library through qpsolvers.

Planar problems only, where the cones are polyhedral. The relaxation differs from Coulomb's law: see problems.forms.relaxation.
Libraries that are called directly (solvers.outside.qp_libraries, solvers.outside.dual_active_set) are not here.

Licence: qpsolvers LGPL-3.0; HiGHS MIT, ECOS GPL-3.0, QPALM LGPL-3.0-or-later.
Form: the dimensionless QP (solvers.outside.scaled_program), dense for ECOS. Setup: qpsolvers' problem. Solve: qpsolvers' call,
    the backend's own setup inside.
Clock: qpsolvers', around the backend's solve, after its setup where the two can be separated.
Settings: for highs qp_regularization_value is 1e-7 by default; tuned is 0.
Tolerance: eps is tol in the units of the scaled program. highs both feasibilities eps/10, no less than 1e-10. qpalm eps_abs =
    eps/10. ecos feastol = eps/10, gaps eps^2, no less than 1e-14. Relative tolerances are 0.
Flaws: ECOS requires a definite matrix and so does not support friction_bias. HiGHS' least feasibility of 1e-10 and ECOS'
    arithmetic leave the residual of some answers at a few times 1e-8.
Reference: Anitescu 2006 for the model; Caron and others, qpsolvers; Huangfu and Hall 2018 (HiGHS); Domahidi, Chu and Boyd 2013
    (ECOS); Hermans, Themelis and Patrinos 2022 (QPALM).
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
    "highs": Backend("highspy", "qp_iteration_limit", 100_000),
    "ecos": Backend("ecos", "max_iters", 200, definite=True),
    "qpalm": Backend("qpalm", "max_iter", 10_000),
}


_LEAST_GAP = 1e-14  # that ECOS reaches
_TUNED: dict[str, dict[str, float]] = {"highs": {"qp_regularization_value": 0.0}}
_VARIANTS = (*(f"backend={name}" for name in BACKENDS), *(f"backend={name},settings=tuned" for name in _TUNED))


@solver("ccp", family="relaxation", model="relaxation", sparse=True, needs=("qpsolvers", "highspy"), variants=_VARIANTS)
class CCP(RelaxationSolver):
    """The convex relaxation as a QP in the velocities, by a library through qpsolvers.

    backend: which library. settings: default or tuned. Work: the backend's iterations, where it reports them.
    """

    backend: str = "highs"
    settings: str = "default"

    @property
    def needs(self) -> tuple[str, ...]:
        return "qpsolvers", BACKENDS[self.backend].distribution

    @property
    def lacks(self) -> tuple[str, ...]:
        return ("friction_bias", "asymmetry") if BACKENDS[self.backend].definite else ("asymmetry",)

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, problem.qp(), from_free=BACKENDS[self.backend].definite)
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
    accuracy, gap = eps / MARGIN, gap_tolerance(eps, _LEAST_GAP)
    return {
        "highs": dict.fromkeys(("primal_feasibility_tolerance", "dual_feasibility_tolerance"), max(accuracy, 1e-10)),
        "ecos": {"feastol": accuracy, "abstol": gap, "reltol": gap},
        "qpalm": {"eps_abs": accuracy, "eps_rel": 0.0},
    }[backend]


def _iterations_and_detail(extras: Mapping[str, Any]) -> tuple[int | None, str]:
    """The iterations and the final status of a backend, each if it reports them."""
    info = extras.get("info", extras)
    if not isinstance(info, Mapping):
        info = {name: getattr(info, name) for name in ("iter", "status") if hasattr(info, name)}
    count = info.get("iter", np.ravel(info.get("iterations", []))[:1].tolist())
    iterations = None if count == [] else int(count[0] if isinstance(count, list) else count)
    return iterations, str(info.get("status", info.get("infostring", "")))
