"""The convex relaxation in the plane by qpmad: Goldfarb and Idnani's dual active set, in C++ with Eigen.

Licence: Apache-2.0.
Form: the dimensionless QP (solvers.outside.scaled_program), dense, G above A. Setup: none. Solve: a solver object and its
    solve.
Clock: none.
Charged: some 25 µs more than a call by hand, twice at 2 contacts, 1.8 times at 10 and 1.1 times at 40: the dimensionless
    program, which gives tolerances one meaning, costs that more than three products of dense arrays.
Settings: its defaults.
Tolerance: its tolerance of 1e-12 is left, as a larger one ends it far from the solution.
Flaws: it requires a definite matrix and so does not support friction_bias. Another model than Coulomb's wherever boxes slide,
    `frictionbench solve stopping_block --solver qpmad`.
Reference: Sherikov, qpmad; Goldfarb and Idnani 1983.
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.relaxation import QP
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.scaled_program import ScaledProgram, scaled_program


class Formed(NamedTuple):
    """qpmad's H, h, A, Alb and Aub besides the scaled program."""

    scaled: ScaledProgram[QP]
    parts: tuple[Array, ...]


@solver("qpmad", family="relaxation", model="relaxation", needs=("pyqpmad",), lacks=("friction_bias", "asymmetry"))
class QPMad:
    """The convex relaxation as a QP by qpmad itself. (outside)

    Work: iterations.
    """

    def form(self, problem: FrictionProblem) -> Formed:
        scaled = scaled_program(problem, problem.qp())
        P, G, A = scaled.dense
        lower, upper = np.full(len(G), -1e30), scaled.h
        if len(A):
            G, lower, upper = np.vstack([G, A]), np.concatenate([lower, scaled.b]), np.concatenate([upper, scaled.b])
        return Formed(scaled, (P, scaled.q, G, lower, upper))

    def solve(self, formed: Formed, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        pyqpmad: Any = import_module("pyqpmad")
        scaled, (P, q, G, lower, upper) = formed
        if not scaled.program.contacts[0]:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        parameters = pyqpmad.SolverParameters()
        parameters.max_iter = limit or 10_000
        made = pyqpmad.Solver()
        H = np.asfortranarray(P.copy())  # it is overwritten by its factor
        try:
            code = made.solve(np.zeros(len(q)), H, q, None, None, G, lower, upper, parameters)
        except (RuntimeError, ValueError) as error:
            return Answer(np.zeros(scaled.program.contacts), Status.FAILED, detail=str(error))
        z, active = np.zeros(len(upper)), made.get_inequality_dual()
        z[active.indices] = active.dual
        status, work = Status.SOLVED if code == pyqpmad.OK else Status.FAILED, {"iterations": int(made.get_num_iterations())}
        return Answer(scaled.impulse(z[: len(scaled.h)]), status, work, detail=code.name)
