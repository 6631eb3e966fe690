"""The convex relaxation by libraries that are called through a modelling layer: qpsolvers, and CVXPY with Clarabel.

The program is that of solvers.outside.scaled_program: a QP in the plane, and by CVXPY a cone program in space,

    min  ½ x'Px + q'x    subject to    h - G x in {s_0 >= |s_1:|} for every contact,    A x = b.

Beside the libraries that are called directly (solvers.outside.qp_libraries, solvers.outside.dual_active_set), CVXPY shows what
a modelling language costs. The relaxation differs from Coulomb's law: see problems.forms.relaxation.
"""

import warnings
from importlib import import_module
from typing import Any

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer
from frictionbench.solvers.outside import STOPPING_MARGIN
from frictionbench.solvers.outside.qp_libraries import clarabel_options
from frictionbench.solvers.outside.scaled_program import ScaledProgram, relaxation_library, scaled_program

_DISTRIBUTIONS = {"highs": ("highspy",), "hipo": ("highspy", "highspy-extras"), "qpalm": ("qpalm",)}
_TUNED: dict[str, dict[str, Any]] = {
    "highs": {"qp_regularization_value": 0.0},
    "hipo": {"hipo_system": "normaleq", "hipo_ordering": "amd"},
    "qpalm": {"sigma_init": 200.0, "factorization_method": 1},
}
_VARIANTS = (*(f"backend={name}" for name in _DISTRIBUTIONS), *(f"backend={name},settings=tuned" for name in _TUNED))


@relaxation_library("ccp", needs=("qpsolvers", "highspy"), variants=_VARIANTS)
class CCP:
    """The convex relaxation as a QP in the velocities, by a library through qpsolvers.

    backend: which library. settings: default or tuned. Work: the backend's iterations, where it reports them.

    Licence: qpsolvers LGPL-3.0; HiGHS MIT, QPALM LGPL-3.0-or-later.
    Form: the dimensionless QP (solvers.outside.scaled_program); highs is given rows and columns alike, as what it adds to P
        changes light bodies more, and the unknowns in reversed order, for docs/fairness.md shows a wrong answer in the natural
        one. Setup: qpsolvers' problem. Solve: qpsolvers' call.
    Clock: qpsolvers', around the backend's solve, after its setup where the two can be separated.
    Settings: for highs, HiGHS' active sets, qp_regularization_value is 1e-7 by default; tuned is 0. hipo is its interior point,
        which chooses its linear systems and their order by default; tuned are hipo_system normaleq and hipo_ordering amd,
        `frictionbench solve 'stack[blocks=20]' --solver 'ccp[backend=hipo]' --solver 'ccp[backend=hipo,settings=tuned]'`. qpalm
        tuned is sigma_init 200, by default 20, and factorization_method 1, the Schur complement, `frictionbench solve
        'stack[blocks=150,push=1]' --solver 'ccp[backend=qpalm]' --solver 'ccp[backend=qpalm,settings=tuned]'`.
    Tolerance: eps is tol in the units of the scaled program. highs and hipo both feasibilities eps/10, no less than 1e-10, and
        hipo a gap of eps^2, no less than 1e-12, its least. qpalm eps_abs = eps/10. Relative tolerances are 0.
    Flaws: HiGHS' least feasibility of 1e-10 leaves the residual of some answers at a few times 1e-8, and HiPO's least gap some
        at 1e-6, `frictionbench solve 'stack[blocks=3]' --solver 'ccp[backend=hipo]'`.
    Reference: Anitescu 2006 for the model; Caron and others, qpsolvers; Huangfu and Hall 2018 (HiGHS); Hermans, Themelis and
        Patrinos 2022 (QPALM).
    """

    backend: str = "highs"
    settings: str = "default"

    @property
    def needs(self) -> tuple[str, ...]:
        return "qpsolvers", *_DISTRIBUTIONS[self.backend]

    def form(self, problem: FrictionProblem) -> tuple[ScaledProgram, Any]:
        highs = self.backend == "highs"
        scaled = scaled_program(problem, from_free=self.backend == "hipo", alike=highs)
        (A, b), P, q, G = scaled.equations, scaled.P, scaled.q, scaled.G
        if highs:
            P, q, G, A = P[::-1, ::-1], q[::-1], G[:, ::-1], None if A is None else A[:, ::-1]
        return scaled, (P, q, G, scaled.h, A, b)

    def setup(self, formed: tuple[ScaledProgram, Any]) -> tuple[ScaledProgram, Any]:
        scaled, arguments = formed
        return scaled, import_module("qpsolvers").Problem(*arguments)

    def solve(self, prepared: tuple[ScaledProgram, Any], tol: float, limit: int | None, start: Array | None = None) -> Answer:
        scaled, qp = prepared
        eps, gap = scaled.tolerances(tol, 1e-12)  # the least gap that HiPO reaches
        accuracy = eps / STOPPING_MARGIN
        feasibilities = "primal_feasibility_tolerance", "dual_feasibility_tolerance"
        highs: dict[str, Any] = dict.fromkeys(feasibilities, max(accuracy, 1e-10))
        settings: dict[str, Any] = {
            "highs": highs | {"qp_iteration_limit": limit or 100_000},
            "hipo": highs | {"solver": "hipo", "ipm_optimality_tolerance": gap, "ipm_iteration_limit": limit or 500},
            "qpalm": {"eps_abs": accuracy, "eps_rel": 0.0, "max_iter": limit or 10_000},
        }[self.backend]
        settings |= _TUNED[self.backend] if self.settings == "tuned" else {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # qpsolvers warns of a failure; the status reports it
            # as qpsolvers.solve_problem, which cannot hand on HiGHS' option `solver`
            call = import_module("qpsolvers.solvers").solve_function["highs" if self.backend == "hipo" else self.backend]
            result = call(qp, **settings)
        info = result.extras.get("info")  # QPALM's; HiGHS reports nothing
        told: tuple[int | None, str] = (int(info.iter), str(info.status)) if info else (None, "")
        return scaled.answer(result.z, result.found, *told, result.solve_time)


@relaxation_library("ccp_cone", dimension=(2, 3), needs=("cvxpy", "clarabel"), variants=("", "settings=tuned"))
class CCPCone:
    """The convex relaxation, with circular cones in space, by CVXPY with Clarabel. (outside)

    settings: default or tuned. Work: Clarabel's iterations.

    Licence: Apache-2.0 (CVXPY and Clarabel).
    Form: `clarabel`'s. Setup: CVXPY builds and canonicalises it. Solve: Clarabel's setup and solve, and CVXPY's unpacking.
    Clock: none that excludes its setup.
    Settings: Clarabel's defaults; tuned are those of `clarabel`, `frictionbench solve 'random_bodies[contacts=8,seed=1]'
        --solver ccp_cone --solver 'ccp_cone[settings=tuned]'`.
    Tolerance: eps is tol in the units of the scaled program: tol_feas = eps, both gaps eps^2, no less than that of `clarabel`.
    Flaws: a gap of eps^2 is often below Clarabel's rounding on circular cones; it then reports failure although the answer is
        accurate, `frictionbench solve 'random_bodies[contacts=2,seed=1]' --solver ccp_cone`.
    Reference: Anitescu and Tasora 2010 for the model; Diamond and Boyd 2016 (CVXPY); Goulart and Chen 2024 (Clarabel).
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> ScaledProgram:
        return scaled_program(problem, from_free=True, alike=self.settings == "tuned")

    def setup(self, scaled: ScaledProgram) -> tuple[ScaledProgram, Any]:
        """The CVXPY problem, and its canonical data with what converts their solution."""
        cvxpy: Any = import_module("cvxpy")
        d, x = scaled.contacts[1], cvxpy.Variable(len(scaled.q))
        s = scaled.h - scaled.G @ x
        constraints = [s >= 0 if d == 2 else cvxpy.SOC(s[::d], cvxpy.vstack([s[j::d] for j in range(1, d)]))]
        if len(scaled.b):
            constraints.append(scaled.A @ x == scaled.b)
        objective = cvxpy.Minimize(cvxpy.quad_form(x, scaled.P, assume_PSD=True) / 2 + scaled.q @ x)
        built = cvxpy.Problem(objective, constraints)
        return scaled, (built, built.get_problem_data("CLARABEL", solver_opts={}))

    def solve(self, prepared: tuple[ScaledProgram, Any], tol: float, limit: int | None, start: Array | None = None) -> Answer:
        cvxpy: Any = import_module("cvxpy")
        scaled, (built, (data, chain, inverse)) = prepared
        settings = clarabel_options(scaled, self.settings, tol, limit)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # CVXPY warns of an inaccurate solution; the status reports it
            raw = chain.solve_via_data(built, data, solver_opts=settings)
            try:
                built.unpack_results(raw, chain, inverse)
            except cvxpy.SolverError as error:
                return scaled.answer(None, False, detail=str(error))
        z, d = built.constraints[0].dual_value, scaled.contacts[1]
        z = None if z is None or z[0] is None else z
        if z is not None and d > 2:
            z = np.column_stack([np.ravel(z[0]), np.reshape(z[1], (d - 1, -1)).T]).ravel()
        return scaled.answer(z, built.status == cvxpy.OPTIMAL, int(built.solver_stats.num_iters), built.status)
