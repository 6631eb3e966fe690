"""The convex relaxation in the plane by dual active sets, of few contacts: DAQP, and Goldfarb and Idnani's method by quadprog.

Form: the dimensionless QP (solvers.outside.scaled_program), dense, G above A, for quadprog A above G. Setup: none. Solve: one
    call, in which the library sets up and solves.
Charged: some 5 µs more than a call by hand at 2 contacts, 15 at 20, .1 ms with the joints of 40: the units in which tolerances
    have one meaning, and what joints hold, of which a call by hand computes nothing.
"""

from importlib import import_module
from typing import Any

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer
from frictionbench.solvers.outside import STOPPING_MARGIN
from frictionbench.solvers.outside.scaled_program import ScaledProgram, relaxation_library, scaled_program

_EQUALITY = 5  # DAQP's sense of a row of A
Prepared = tuple[ScaledProgram, Any]  # and the library's arguments


@relaxation_library("daqp", needs=("daqp",))
class DAQP:
    """The convex relaxation as a QP by DAQP itself. (outside)

    Work: iterations.

    Licence: MIT.
    Clock: DAQP's own setup_time and solve_time together.
    Settings: its defaults.
    Tolerance: primal_tol and dual_tol eps/10, by default 1e-6 and 1e-12; eps stands for tol.
    Reference: Arnström, Bemporad and Axehill 2022.
    """

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, dense=True)
        sense = np.zeros(len(scaled.right), dtype=np.int32)
        sense[len(scaled.h) :] = _EQUALITY
        return scaled, (scaled.P, scaled.q, scaled.stacked(), scaled.right, scaled.least(-1e30), sense)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        daqp: Any = import_module("daqp")
        scaled, arguments = prepared
        accuracy = tol * scaled.share / STOPPING_MARGIN
        _, _, flag, info = daqp.solve(*arguments, primal_tol=accuracy, dual_tol=accuracy, iter_limit=limit or 10_000)
        clock = float(info["setup_time"] + info["solve_time"])
        return scaled.answer(np.array(info["lam"]), flag > 0, int(info["iterations"]), f"exit flag {flag}", clock)


@relaxation_library("quadprog", needs=("quadprog",), lacks=("friction_bias", "asymmetry"))
class Quadprog:
    """The convex relaxation as a QP by quadprog itself. (outside)

    Work: iterations.

    Licence: GPL-2.0-or-later.
    Clock: none.
    Settings: it has none.
    Tolerance: it takes none.
    Flaws: it requires a definite matrix and so does not support friction_bias.
    Reference: Goldfarb and Idnani 1983.
    """

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, dense=True)
        right = np.concatenate([scaled.b, scaled.h]) if len(scaled.b) else scaled.right
        return scaled, (scaled.P, -scaled.q, -scaled.stacked(joints_first=True).T, -right, len(scaled.b))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        quadprog: Any = import_module("quadprog")
        scaled, arguments = prepared
        try:
            _, _, _, iterations, multipliers, _ = quadprog.solve_qp(*arguments)
        except ValueError as error:
            return scaled.answer(None, False, detail=str(error))
        return scaled.answer(multipliers[len(scaled.b) :], True, int(iterations[0]))
