"""Pinocchio's solvers of contact problems: ADMM and projected Gauss-Seidel on a Delassus operator.

Licence: BSD-2-Clause by the text that it ships.
Form: the dimensionless Delassus matrix with three rows a contact, (t1, t2, n); the second tangent of a planar one is
    decoupled. Setup: the operator and one point contact model a contact. Solve: the solver's solve, and reading the impulses.
Clock: none.
Tolerance: absolute feasibility and complementarity of eps/10 for ADMM and eps/100 for PGS, whose criterion is weaker still,
    eps as in solvers.outside.scaled_delassus; relative tolerances are off.
Flaws: ADMM does not converge in 20 000 iterations with large mass ratios, `frictionbench solve
    'stack[blocks=5,mass_ratio=1e6,push=1]' --solver 'pinocchio[method=admm]'`. Without friction PGS stops at once and reports
    success, `frictionbench solve 'stack[blocks=1,friction=0,push=1]' --solver 'pinocchio[method=pgs]'`. With solve_ncp off it
    solves the relaxation, here law=ccp.
Reference: Carpentier, Montaut and Le Lidec 2024, "From compliant to rigid contact simulation"; Le Lidec and others 2024.
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.solvers.interface import Answer, Model, Status, impulses, solver
from frictionbench.solvers.outside.margin import MARGIN
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus, scaled_delassus

_SOLVERS = {"admm": "ADMM", "pgs": "PGS"}
_MARGINS = {"admm": MARGIN, "pgs": 10 * MARGIN}
_LAWS: dict[str, Model] = {"ncp": "coulomb", "ccp": "relaxation"}
_OPERATORS = {"dense": "DelassusOperatorDense", "sparse": "DelassusOperatorSparse"}
_VARIANTS = ("method=admm", "method=admm,operator=sparse", "method=admm,law=ccp", "method=pgs")


class Prepared(NamedTuple):
    given: ScaledDelassus
    operator: Any
    g: Array
    models: Any
    datas: Any
    order: Array


@solver(
    "pinocchio",
    family="splitting",
    model="coulomb",
    dimension=(2, 3),
    warm_start=True,
    needs=("pin",),
    lacks=("friction_bias",),
    variants=_VARIANTS,
)
class Pinocchio:
    """Pinocchio's ADMM or projected Gauss-Seidel. (outside)

    method: admm or pgs. law: ncp, Coulomb's, or ccp, the relaxation. operator: dense or sparse. Work: iterations.
    """

    method: str = "admm"
    law: str = "ncp"
    operator: str = "dense"

    def __post_init__(self) -> None:
        for name, known in (("method", _SOLVERS), ("law", _LAWS), ("operator", _OPERATORS)):
            require(getattr(self, name) in known, name, f"must be one of {', '.join(known)}, got {getattr(self, name)!r}")
        require(self.method == "admm" or self.operator == "dense", "operator", "PGS supports only the dense operator")

    @property
    def model(self) -> Model:
        return _LAWS[self.law]

    def form(self, problem: FrictionProblem) -> ScaledDelassus:
        return scaled_delassus(problem)

    def setup(self, given: ScaledDelassus) -> Prepared:
        pin: Any = import_module("pinocchio")
        W, q = given.in_space()
        order = (3 * np.arange(len(given.friction))[:, None] + [1, 2, 0]).ravel()
        W = np.asfortranarray(W[np.ix_(order, order)])
        operator = getattr(pin, _OPERATORS[self.operator])(sparse.csc_matrix(W) if self.operator == "sparse" else W)
        body = pin.Model()
        body.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
        models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
        for mu in given.friction:
            point = pin.PointContactConstraintModel(body, 0, pin.SE3.Identity(), 1, pin.SE3.Identity())
            point.setFriction(mu)
            model = pin.ConstraintModel(point)
            models.append(model)
            datas.append(model.createData())
        return Prepared(given, operator, q[order], models, datas, order)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        pin: Any = import_module("pinocchio")
        given, operator, g, models, datas, order = prepared
        if not len(g):
            return Answer(np.zeros(given.contacts), Status.SOLVED)
        name = _SOLVERS[self.method]
        settings, result = getattr(pin, f"{name}SolverSettings")(), getattr(pin, f"{name}SolverResult")()
        settings.solve_ncp, settings.max_iterations = self.law == "ncp", limit or 20_000
        settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = given.share * tol / _MARGINS[self.method]
        settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
        if start is not None:
            result.setConstraintImpulseGuess(given.to_space(impulses(start, given.contacts))[order])
        found = getattr(pin, f"{name}ConstraintSolver")().solve(operator, g, models, datas, settings, result)
        r = np.empty(len(g))
        r[order] = result.retrieveConstraintImpulses()
        status = Status.SOLVED if found else Status.WORK_LIMIT
        return Answer(given.from_space(r), status, {"iterations": int(result.iterations)})
