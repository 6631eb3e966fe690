"""The convex relaxation in the plane by DAQP's own Python interface: a dual active set.

Licence: MIT.
Form: the dimensionless QP (solvers.outside.scaled_program), dense, G and A stacked. Setup: none, as one call sets up and
    solves. Solve: daqp.solve.
Clock: DAQP's own setup_time and solve_time together.
Charged: some 25 µs more than a call by hand, twice at 2 contacts, 1.8 times at 10 and 1.1 times at 40: the dimensionless
    program, which gives tolerances one meaning, costs that more than three products of dense arrays.
Settings: its defaults.
Tolerance: primal and dual eps/10; eps stands for tol.
Flaws: another model than Coulomb's wherever boxes slide, `frictionbench solve stopping_block --solver daqp`.
Reference: Arnström, Bemporad and Axehill 2022.
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.relaxation import QP
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.margin import MARGIN
from frictionbench.solvers.outside.scaled_program import ScaledProgram, scaled_program

_EQUALITY = 5  # DAQP's sense of a row of A


class Formed(NamedTuple):
    """DAQP's H, f, A, bupper, blower and sense besides the scaled program."""

    scaled: ScaledProgram[QP]
    parts: tuple[Any, ...]


@solver("daqp", family="relaxation", model="relaxation", needs=("daqp",), lacks=("asymmetry",))
class DAQP:
    """The convex relaxation as a QP by DAQP itself. (outside)

    Work: iterations.
    """

    def form(self, problem: FrictionProblem) -> Formed:
        scaled = scaled_program(problem, problem.qp())
        P, G, A = scaled.dense
        lower, sense = np.full(len(G) + len(A), -1e30), np.zeros(len(G) + len(A), dtype=np.int32)
        if not len(A):
            return Formed(scaled, (P, scaled.q, G, scaled.h, lower, sense))
        lower[len(G) :], sense[len(G) :] = scaled.b, _EQUALITY
        return Formed(scaled, (P, scaled.q, np.vstack([G, A]), np.concatenate([scaled.h, scaled.b]), lower, sense))

    def solve(self, formed: Formed, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        daqp: Any = import_module("daqp")
        scaled, parts = formed
        if not scaled.program.contacts[0]:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        eps = tol * scaled.share / MARGIN
        _, _, flag, info = daqp.solve(*parts, primal_tol=eps, dual_tol=eps, iter_limit=limit or 10_000)
        status, work = Status.SOLVED if flag > 0 else Status.FAILED, {"iterations": int(info["iterations"])}
        z, clock = np.array(info["lam"])[: len(scaled.h)], float(info["setup_time"] + info["solve_time"])
        return Answer(scaled.impulse(z), status, work, detail=f"exit flag {flag}", clock=clock)
