"""The convex relaxation in the plane by PIQP's own Python interface.

Licence: BSD-2-Clause.
Form: the dimensionless QP (solvers.outside.scaled_program), sparse. Setup: PIQP's solver object and its setup. Solve: its
    solve.
Clock: PIQP's own solve_time.
Settings: compute_timings on.
Tolerance: eps_abs = eps, gap eps^2, no less than 3e-16; relative tolerances are 0; eps stands for tol.
Flaws: another model than Coulomb's wherever boxes slide, `frictionbench solve stopping_block --solver piqp`.
Reference: Schwan, Jiang, Kuhn and Jones 2023.
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.relaxation import QP
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.scaled_program import ScaledProgram, gap_tolerance, scaled_program

LEAST_GAP = 3e-16  # with 1e-15 errors of 8e-8 remain in closed loop, and with 1e-16 it takes ten times as many iterations


class Formed(NamedTuple):
    """PIQP's P, c, A, b, G, h_l and h_u besides the scaled program."""

    scaled: ScaledProgram[QP]
    parts: tuple[Any, ...]


class Prepared(NamedTuple):
    scaled: ScaledProgram[QP]
    solver: Any


@solver("piqp", family="relaxation", model="relaxation", sparse=True, needs=("piqp",), lacks=("asymmetry",))
class PIQP:
    """The convex relaxation as a QP by PIQP itself. (outside)

    Work: iterations.
    """

    def form(self, problem: FrictionProblem) -> Formed:
        scaled = scaled_program(problem, problem.qp(), from_free=True)
        equality = (None, None) if scaled.A is None else (scaled.A, scaled.b)
        return Formed(scaled, (scaled.P, scaled.q, *equality, scaled.G, None, scaled.h))

    def setup(self, formed: Formed) -> Prepared:
        made = import_module("piqp").SparseSolver()
        made.settings.compute_timings = True
        if formed.scaled.program.contacts[0]:
            made.setup(*formed.parts)
        return Prepared(formed.scaled, made)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        piqp: Any = import_module("piqp")
        scaled, made = prepared
        if not scaled.program.contacts[0]:
            return Answer(scaled.impulse(scaled.h), Status.SOLVED)
        eps, settings = tol * scaled.share, made.settings
        settings.eps_abs, settings.eps_rel, settings.max_iter = eps, 0.0, limit or 500
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = gap_tolerance(eps, LEAST_GAP), 0.0
        found = made.solve()
        result = made.result
        status = Status.SOLVED if found == piqp.PIQP_SOLVED else Status.FAILED
        work = {"iterations": int(result.info.iter)}
        return Answer(
            scaled.impulse(np.array(result.z_u)), status, work, detail=found.name, clock=float(result.info.solve_time)
        )
