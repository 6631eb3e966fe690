"""Pinocchio's solvers of contact problems: ADMM and projected Gauss-Seidel on a Delassus operator.

Licence: BSD-2-Clause by the text that it ships.
Form: the dimensionless Delassus matrix, of which it reads a triangle, with three rows a contact, (t1, t2, n); the second
    tangent of a planar one is decoupled. Its diagonal is 1, for ADMM 2, in the plane where bodies are known 4. It is dense, and
    sparse for ADMM above 60 contacts if less than half full. Setup: the operator, and the coefficients of friction in point
    contact models that are kept for each number of contacts. Solve: its solve, and reading the impulses.
Clock: the solver's getElapsedTime, with measure_timings on.
Charged: on some problems it takes several times the iterations of a call by hand, which gives it W in units of kg and asks
    tol/10 of impulses and velocities as they are, and on others a fraction.
Settings: ADMM's defaults have no Anderson acceleration, anderson_capacity = 0, estimate the largest eigenvalue of W by as many
    steps of Lanczos as W has rows, lanczos_size = 2^31 - 1, which is not in its clock, and may change rho any number of times,
    max_delassus_decomposition_updates = 2^31 - 1; tuned sets 8, 10 and 10, with fewer iterations, `frictionbench solve
    'stack[blocks=10,mass_ratio=100,push=1]' --solver 'pinocchio[method=admm]' --solver 'pinocchio[settings=tuned]'`. PGS'
    over_relaxation is 1; tuned is 1.3, `frictionbench solve 'wedge[friction=0.2]' --solver 'pinocchio[method=pgs]' --solver
    'pinocchio[method=pgs,settings=tuned]'`.
Tolerance: absolute feasibility and complementarity of eps/10 for ADMM and eps/100 for PGS, whose criterion is weaker still,
    not less than 1e-14, eps as in solvers.outside.scaled_delassus; relative tolerances are off.
Flaws: ADMM without acceleration does not converge in 20 000 iterations with large mass ratios, `frictionbench solve
    'stack[blocks=5,mass_ratio=1e6,push=1]' --solver 'pinocchio[method=admm]'`. PGS stops at once and reports success on some
    problems, with and without friction, `frictionbench solve wedge --solver 'pinocchio[method=pgs]'`, `frictionbench solve
    'stack[blocks=1,friction=0,push=1]' --solver 'pinocchio[method=pgs]'`.
Reference: Carpentier, Le Lidec and Montaut 2024, "From compliant to rigid contact simulation"; Le Lidec and others 2024.
"""

from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Model, Status, solver
from frictionbench.solvers.outside import STOPPING_MARGIN
from frictionbench.solvers.outside.scaled_delassus import TANGENTS_FIRST, ScaledDelassus, entries, scaled_delassus

_MARGINS = {"admm": STOPPING_MARGIN, "pgs": 10 * STOPPING_MARGIN}
# The diagonal of W^ in the plane where the mechanics are known, and elsewhere. ADMM's mu_prox and its updates of rho depend on
# units: tuned it takes 247 iterations on 31 planar problems with 4 and 306 with 2, on 18 recorded ones 280 and 161.
_SIZES = {"admm": (4.0, 2.0), "pgs": (1.0, 1.0)}
_LEAST = 1e-14  # of tolerances, for rounding
_DENSE = 60  # contacts up to which ADMM's dense operator is the faster one
_VARIANTS = tuple(f"method={each}{more}" for each in ("admm", "admm,law=ccp", "pgs") for more in ("", ",settings=tuned"))
_TUNED: dict[str, dict[str, float]] = {
    "admm": {"anderson_capacity": 8, "lanczos_size": 10, "max_delassus_decomposition_updates": 10},
    "pgs": {"over_relaxation": 1.3},
}
Prepared = tuple[ScaledDelassus, Any, Any, Any]  # the operator, the contact models and their data


@lru_cache(maxsize=8)
def _contacts(nc: int) -> tuple[Any, Any, Any]:
    """A point contact, and nc models of it with their data, whose coefficients of friction are overwritten."""
    pin: Any = import_module("pinocchio")
    body = pin.Model()
    body.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    point = pin.PointContactConstraintModel(body, 0, pin.SE3.Identity(), 1, pin.SE3.Identity())
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for _ in range(nc):
        models.append(pin.ConstraintModel(point))
        datas.append(models[-1].createData())
    return point, models, datas


@solver(
    "pinocchio",
    family="splitting",
    model="coulomb",
    dimension=(2, 3),
    warm_start=True,
    needs=("pin",),
    lacks=("friction_bias", "asymmetry"),
    variants=_VARIANTS,
)
class Pinocchio:
    """Pinocchio's ADMM or projected Gauss-Seidel. (outside)

    method: admm or pgs. law: ncp, Coulomb's, or ccp, the relaxation. settings: default or tuned. Work: iterations.
    """

    method: str = "admm"
    law: str = "ncp"
    settings: str = "default"

    @property
    def model(self) -> Model:
        return "coulomb" if self.law == "ncp" else "relaxation"

    def form(self, problem: FrictionProblem) -> tuple[ScaledDelassus, Any]:
        """The scaling, and W^ dense or sparse."""
        n = problem.contacts
        dense = self.method == "pgs" or n <= _DENSE or 2 * len(problem.blocks.neighbours) > n**2
        size = _SIZES[self.method][problem.dimension == 3 or not problem.mechanical]
        scaled = scaled_delassus(problem, TANGENTS_FIRST, matrix=dense, size=size)
        if dense:
            return scaled, scaled.W.T
        row, column, value = entries(*problem.blocks, scaled.E, TANGENTS_FIRST).T
        return scaled, sparse.csc_matrix((value, (row.astype(int), column.astype(int))), shape=(3 * n, 3 * n))

    def setup(self, formed: tuple[ScaledDelassus, Any]) -> Prepared:
        pin: Any = import_module("pinocchio")
        scaled, W = formed
        operator = (pin.DelassusOperatorSparse if sparse.issparse(W) else pin.DelassusOperatorDense)(W)
        point, models, datas = _contacts(len(scaled.friction))
        for k, mu in enumerate(scaled.friction.tolist()):
            point.setFriction(mu)
            models[k] = pin.ConstraintModel(point)
        return scaled, operator, models, datas

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        pin: Any = import_module("pinocchio")
        scaled, operator, models, datas = prepared
        name = self.method.upper()
        settings, result = getattr(pin, f"{name}SolverSettings")(), getattr(pin, f"{name}SolverResult")()
        settings.solve_ncp, settings.max_iterations = self.law == "ncp", limit or 20_000
        accuracy = max(scaled.share * tol / _MARGINS[self.method], _LEAST)
        settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = accuracy
        settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
        settings.measure_timings = True
        for option, value in (_TUNED[self.method] if self.settings == "tuned" else {}).items():
            setattr(settings, option, value)
        if start is not None:
            result.setConstraintImpulseGuess(scaled.guess(start))
        solver = getattr(pin, f"{name}ConstraintSolver")()
        solved = solver.solve(operator, scaled.q, models, datas, settings, result)
        r, status = np.array(result.retrieveConstraintImpulses()), Status.SOLVED if solved else Status.WORK_LIMIT
        return scaled.answer(r, status, clock=solver.getElapsedTime() * 1e-6, iterations=int(result.iterations))
