"""The convex relaxation in the plane by dual active sets, of few contacts: DAQP, and Goldfarb and Idnani's method by quadprog.

Form: the dimensionless QP about the free motion, dense, G above A, for quadprog A above G (solvers.outside.scaled_program). No
    tolerance changes an answer of active sets beyond rounding, so that no units of tolerances are computed, nor are islands of
    unlike speeds balanced (solvers.balanced) unless the problem is given by W. Setup: none. Solve: one call, in which the
    library sets up and solves.
"""

from importlib import import_module
from typing import Any

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer
from frictionbench.solvers.outside.scaled_program import ScaledProgram, relaxation_library, scaled_program

_EQUALITY = 5  # DAQP's sense of a row of A
_DAQP_TOLERANCE = 1e-12  # relative to the fastest contact: from 1e-9 to 1e-13 DAQP takes as many iterations on 148 problems
Prepared = tuple[ScaledProgram, Any]  # and the library's arguments


@relaxation_library("daqp", warm_start=True, needs=("daqp",))
class DAQP:
    """The convex relaxation as a QP by DAQP itself. (outside)

    Work: iterations.

    Licence: MIT.
    Clock: DAQP's own setup_time and solve_time together.
    Settings: its defaults. A start gives the first active set, by its multipliers (dual_start).
    Tolerance: primal_tol and dual_tol 1e-12 times the largest free velocity, by default 1e-6 and 1e-12, for every tol.
    Reference: Arnström, Bemporad and Axehill 2022.
    """

    exact = True

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, dense=True, from_free=True, exact=problem.mechanical)
        sense = np.zeros(len(scaled.right), dtype=np.int32)
        sense[len(scaled.h) :] = _EQUALITY
        return scaled, (scaled.P, scaled.q, scaled.stacked(), scaled.right, scaled.least(-1e30), sense)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        daqp: Any = import_module("daqp")
        scaled, arguments = prepared
        accuracy = _DAQP_TOLERANCE * float(abs(scaled.right).max()) or _DAQP_TOLERANCE
        options: dict[str, Any] = {"primal_tol": accuracy, "dual_tol": accuracy, "iter_limit": limit or 10_000}
        if start is not None:
            options["dual_start"] = np.append(scaled.multipliers(start), np.zeros(len(scaled.b)))
        _, _, flag, info = daqp.solve(*arguments, **options)
        clock = float(info["setup_time"] + info["solve_time"])
        return scaled.answer(np.array(info["lam"]), flag > 0, int(info["iterations"]), f"exit flag {flag}", clock)


@relaxation_library("quadprog", needs=("quadprog",), lacks=("friction_bias", "asymmetry"))
class Quadprog:
    """The convex relaxation as a QP by quadprog itself. (outside)

    Work: iterations.

    Licence: GPL-2.0-or-later.
    Clock: none.
    Settings: factorized, which spares it the factorisation of a diagonal P.
    Tolerance: it takes none.
    Flaws: it requires a definite matrix and so does not support friction_bias.
    Reference: Goldfarb and Idnani 1983.
    """

    exact = True

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, dense=True, from_free=True, exact=problem.mechanical)
        right = np.concatenate([scaled.b, scaled.h]) if len(scaled.b) else scaled.right
        P = np.diag(scaled.P.diagonal() ** -0.5) if scaled.diagonal else scaled.P  # the inverse of the root of P
        return scaled, (P, -scaled.q, -scaled.stacked(joints_first=True).T, -right, len(scaled.b), scaled.diagonal)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        quadprog: Any = import_module("quadprog")
        scaled, arguments = prepared
        try:
            _, _, _, iterations, multipliers, _ = quadprog.solve_qp(*arguments)
        except ValueError as error:
            return scaled.answer(None, False, detail=str(error))
        return scaled.answer(multipliers[len(scaled.b) :], True, int(iterations[0]))
