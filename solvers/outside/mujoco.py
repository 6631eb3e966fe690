"""MuJoCo's constraint solvers on a given friction problem, in a child process, as such calls can crash.

Its contacts are soft: Newton and CG minimise the relaxation with u = W r + q + R r, and R determines the distance from hard
contacts. Here R = max(tol, 1e-7) s at every contact, so that a ladder of tolerances is a sweep of R; with smaller R Newton
diverges.

Licence: Apache-2.0.
Form: dimensionless contact rows, three a contact, on velocities whitened by the mass's Cholesky factor. Setup: MuJoCo's
    template, once per size. Solve: mj_fwdConstraint, including the transfer of the rows into the template.
Clock: around mj_fwdConstraint, in the child.
Tolerance: R as above, and MuJoCo's tolerance 0: it iterates until it makes no progress, and its gradient decides the status.
Flaws: soft contacts. Newton stalls where R is small against W, `frictionbench solve 'random_bodies[seed=1,contacts=20]'
    --solver 'mujoco[method=newton]'`; CG is far from the minimum after 2000 iterations, `frictionbench solve
    'stack[blocks=5,friction=0.2,push=1]' --solver 'mujoco[method=cg]'`.
Reference: Todorov 2014, "Convex and analytically-invertible dynamics with contacts and constraints".
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.children.child import child
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus, scaled_delassus

_METHODS = {"newton": "Newton", "cg": "CG"}
_ITERATIONS = {"newton": 200, "cg": 2000}  # by default: Newton converges in tens or not at all
_LEAST = 1e-7  # of R/s: below, MuJoCo's Newton diverges
_SCRIPT = "mujoco_rows.py"


class Prepared(NamedTuple):
    """The rows J^ (3 nc, nv), v^ (nv,) and b^ (3 nc,), with W^ = J^ J^' and q^ = J^ v^ + b^."""

    given: ScaledDelassus
    J: Array
    v: Array
    b: Array


@solver(
    "mujoco",
    family="outside",
    model="regularised",
    dimension=(2, 3),
    needs=("mujoco",),
    lacks=("friction_bias", "joints"),
    variants=("method=newton", "method=cg"),
)
class MuJoCo:
    """MuJoCo's Newton or CG on soft contacts, in a child process. (outside)

    method: newton or cg. Work: iterations.
    """

    method: str = "newton"

    def __post_init__(self) -> None:
        require(self.method in _METHODS, "method", f"must be one of {', '.join(_METHODS)}, got {self.method!r}")

    def form(self, problem: FrictionProblem) -> Prepared:
        given, nc, d = scaled_delassus(problem), problem.contacts, problem.dimension
        root = np.linalg.cholesky(problem.mass.toarray())
        J, b = np.zeros((nc, 3, len(root))), np.zeros((nc, 3))
        rows = given.E[:, None] * np.linalg.solve(root, problem.jacobian.toarray().T).T
        J[:, :d], b[:, :d] = rows.reshape(nc, d, len(root)), given.E.reshape(nc, d) * problem.offset / given.theta
        return Prepared(given, J.reshape(3 * nc, len(root)), root.T @ problem.free_velocity / given.theta, b.ravel())

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        given, J, v, b = prepared
        if not len(given.friction):
            return Answer(np.zeros(given.contacts), Status.SOLVED)
        asked = {"solver": _METHODS[self.method], "iterations": limit or _ITERATIONS[self.method], "R": max(tol, _LEAST)}
        found = child(_SCRIPT).ask(**asked, J=J, v=v, b=b, mu=given.friction)
        return Answer(
            given.from_space(found["f"]),
            Status.SOLVED if found["gradient"] <= given.share * tol else Status.STALLED,
            {"iterations": found["iterations"]},
            detail=f"gradient {found['gradient']:.1e}",
            clock=found["clock"],
            softness=max(tol, _LEAST) * np.outer(given.scale, np.ones(given.contacts[1])),
        )
