"""The convex relaxation as a cone program, written in CVXPY and solved by Clarabel.

    min  ½ x'Px + q'x    subject to    h - G x in {s_0 >= |s_1:|} for every contact,    A x = b

with the circular cone in space; in the plane h - G x >= 0, which is the same. The relaxation differs from Coulomb's law: see
problems.forms.relaxation. Against `clarabel`, which hands the same program over directly, it shows what the modelling language
costs.

Licence: Apache-2.0 (CVXPY and Clarabel).
Form: the dimensionless program (solvers.outside.scaled_program). Setup: CVXPY builds and canonicalises it. Solve:
    Clarabel's, its own setup inside, and CVXPY's unpacking.
Clock: none that excludes its setup.
Settings: Clarabel's defaults.
Tolerance: eps is tol in the units of the scaled program: tol_feas = eps, both gaps eps^2, no less than that of `clarabel`.
Flaws: a gap of eps^2 is often below Clarabel's rounding on circular cones; it then reports failure although the answer is
    accurate, `frictionbench solve 'random_bodies[seed=0,contacts=4]' --solver ccp_cone`. The model differs from Coulomb's law
    where bodies slide.
Reference: Anitescu and Tasora 2010 for the model; Diamond and Boyd 2016 (CVXPY); Goulart and Chen 2024 (Clarabel).
"""

import warnings
from importlib import import_module
from typing import Any

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, solver
from frictionbench.solvers.outside.qp_libraries import LEAST_GAP
from frictionbench.solvers.outside.scaled_program import Prepared, RelaxationSolver, gap_tolerance, scaled_relaxation


@solver(
    "ccp_cone",
    family="relaxation",
    model="relaxation",
    dimension=(2, 3),
    sparse=True,
    needs=("cvxpy", "clarabel"),
    lacks=("asymmetry",),
)
class CCPCone(RelaxationSolver):
    """The convex relaxation, with circular cones in space, by CVXPY with Clarabel. (outside)

    Work: Clarabel's iterations.
    """

    def form(self, problem: FrictionProblem) -> Prepared:
        return Prepared(scaled_relaxation(problem, from_free=True), None)

    def create(self, formed: Prepared) -> Any:
        """The CVXPY problem, and its canonical data with what converts their solution."""
        cvxpy: Any = import_module("cvxpy")
        scaled = formed.scaled
        d = scaled.program.contacts[1]
        x = cvxpy.Variable(len(scaled.q))
        s = scaled.h - scaled.G @ x
        constraints = [s >= 0 if d == 2 else cvxpy.SOC(s[::d], cvxpy.vstack([s[j::d] for j in range(1, d)]))]
        if scaled.A is not None:
            constraints.append(scaled.A @ x == scaled.b)
        objective = cvxpy.Minimize(cvxpy.quad_form(x, scaled.P, assume_PSD=True) / 2 + scaled.q @ x)
        built = cvxpy.Problem(objective, constraints)
        return built, built.get_problem_data("CLARABEL", solver_opts={})

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        cvxpy: Any = import_module("cvxpy")
        scaled, (built, (data, chain, inverse)) = prepared
        gap = gap_tolerance(eps, LEAST_GAP["clarabel"])
        settings = {"tol_feas": eps, "tol_gap_abs": gap, "tol_gap_rel": gap, "max_iter": limit or 200}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # CVXPY warns of an inaccurate solution; the status reports it
            raw = chain.solve_via_data(built, data, solver_opts=settings)
            try:
                built.unpack_results(raw, chain, inverse)
            except cvxpy.SolverError as error:
                return scaled.answer(None, False, detail=str(error))
        z, d = built.constraints[0].dual_value, scaled.program.contacts[1]
        z = None if z is None or z[0] is None else z
        if z is not None and d > 2:
            z = np.column_stack([np.ravel(z[0]), np.reshape(z[1], (d - 1, -1)).T]).ravel()
        return scaled.answer(z, built.status == cvxpy.OPTIMAL, int(built.solver_stats.num_iters), built.status)
