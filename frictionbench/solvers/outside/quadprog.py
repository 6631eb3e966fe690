"""The convex relaxation in the plane by quadprog: Goldfarb and Idnani's dual active set.

Licence: GPL-2.0-or-later.
Form: the dimensionless QP (solvers.outside.scaled_program), dense, A above G. Setup: none. Solve: quadprog's solve_qp.
Clock: none.
Charged: some 25 µs more than a call by hand, twice at 2 contacts, 1.8 times at 10 and 1.1 times at 40: the dimensionless
    program, which gives tolerances one meaning, costs that more than three products of dense arrays.
Settings: it has none.
Tolerance: it takes none.
Flaws: it requires a definite matrix and so does not support friction_bias. Another model than Coulomb's wherever boxes slide,
    `frictionbench solve stopping_block --solver quadprog`.
Reference: Goldfarb and Idnani 1983.
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
    """quadprog's G, a, C and b besides the scaled program."""

    scaled: ScaledProgram[QP]
    parts: tuple[Array, ...]


@solver("quadprog", family="relaxation", model="relaxation", needs=("quadprog",), lacks=("friction_bias", "asymmetry"))
class Quadprog:
    """The convex relaxation as a QP by quadprog itself. (outside)

    Work: iterations.
    """

    def form(self, problem: FrictionProblem) -> Formed:
        scaled = scaled_program(problem, problem.qp())
        P, G, A = scaled.dense
        bounds = (G, scaled.h) if not len(A) else (np.vstack([A, G]), np.concatenate([scaled.b, scaled.h]))
        return Formed(scaled, (P, -scaled.q, -bounds[0].T, -bounds[1]))

    def solve(self, formed: Formed, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        quadprog: Any = import_module("quadprog")
        scaled, parts = formed
        if not scaled.program.contacts[0]:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        try:
            _, _, _, iterations, multipliers, _ = quadprog.solve_qp(*parts, len(scaled.b))
        except ValueError as error:
            return Answer(np.zeros(scaled.program.contacts), Status.FAILED, detail=str(error))
        z = multipliers[len(scaled.b) :]
        return Answer(scaled.impulse(z), Status.SOLVED, {"iterations": int(iterations[0])})
