"""The convex relaxation by the Python interfaces of Clarabel, OSQP, ProxSuite, PIQP and SCS, as a simulator uses them.

Form: the dimensionless QP (solvers.outside.scaled_program), sparse. Setup: the library's object, its ordering and scaling.
    Solve: its solve.
"""

from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.relaxation import ConeProgram
from frictionbench.solvers.interface import Answer, solver
from frictionbench.solvers.outside import MARGIN
from frictionbench.solvers.outside.scaled_program import (
    Prepared,
    RelaxationSolver,
    gap_tolerance,
    scaled_program,
    scaled_relaxation,
)

LEAST_GAP = {
    # With 1e-16 it takes 1.5 times as many iterations on stacks and reports failure for half of its accurate answers in space;
    # with 3e-15 a fifth of those answers is off by up to 1.4e-8.
    "clarabel": 1e-15,
    "proxsuite": 1e-14,
    "piqp": 1e-15,  # with 3e-16 it takes five times as many iterations on pyramids, with 1e-14 errors of 1e-7 remain on stacks
}
_CLARABEL_TUNED = {
    "equilibrate_enable": False,
    "static_regularization_constant": 1e-12,
    "iterative_refinement_abstol": 1e-16,
    "iterative_refinement_reltol": 1e-16,
}
_INFEASIBILITY = 1e-14  # of ProxQP, tuned


@solver(
    "clarabel",
    family="relaxation",
    model="relaxation",
    dimension=(2, 3),
    sparse=True,
    needs=("clarabel",),
    lacks=("asymmetry",),
    variants=("settings=default", "settings=tuned"),
)
class Clarabel(RelaxationSolver):
    """The convex relaxation by Clarabel itself, with circular cones in space. (outside)

    settings: default or tuned. Work: iterations.

    Licence: Apache-2.0.
    Form: the dimensionless program (solvers.outside.scaled_program), A and G stacked, P's upper half. Setup: Clarabel's solver
        object, its ordering and scaling. Solve: its solve. (It has no warm start.)
    Clock: its solve_time, which includes its setup.
    Settings: presolve off, which would forbid setting tolerances afterwards. tuned is for programs that are already scaled, as
        these are: equilibrate_enable off, static_regularization_constant = 1e-12 instead of 1e-8, and
        iterative_refinement_abstol and iterative_refinement_reltol 1e-16 instead of 1e-12 and 1e-13, `frictionbench solve
        'stack[blocks=50,mass_ratio=1e6,push=1]' --solver 'clarabel' --solver 'clarabel[settings=tuned]'`.
    Tolerance: tol_feas = eps, both gaps eps^2, no less than 1e-15; eps stands for tol.
    Flaws: its gap is the difference of two objectives, which rounding can make 0 before the answer is accurate: some answers
        that it calls Solved are off by a few times 1e-8. Or it stays above eps^2, and it reports failure although the answer
        is accurate, `frictionbench solve 'random_bodies[seed=0,contacts=4]' --solver clarabel`.
        By default it also calls answers Solved that are off by 1e-5, `frictionbench solve
        'robot_step[case=adroit_hammer-harsh-099]' --solver clarabel`; linear cones for limits and dry friction do not change
        that (7e-6), a static regularisation of 1e-12 does.
    Reference: Goulart and Chen 2024.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_relaxation(problem, from_free=True)
        return Prepared(scaled, (scaled.upper, scaled.q, scaled.constraints, np.concatenate([scaled.h, scaled.b])))

    def create(self, formed: Prepared) -> Any:
        clarabel: Any = import_module("clarabel")
        scaled = formed.scaled
        cones = [clarabel.NonnegativeConeT(len(scaled.h))]
        if isinstance(scaled.program, ConeProgram):
            cones = [clarabel.SecondOrderConeT(3)] * (len(scaled.h) // 3)
        cones = [*cones, clarabel.ZeroConeT(len(scaled.b))] if len(scaled.b) else cones
        return clarabel.DefaultSolver(*formed.given, cones, self._settings())

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        clarabel: Any = import_module("clarabel")
        scaled, made = prepared
        gap = gap_tolerance(eps, LEAST_GAP["clarabel"])
        made.update(settings=self._settings(tol_feas=eps, tol_gap_abs=gap, tol_gap_rel=gap, max_iter=limit or 200))
        found = made.solve()
        solved = found.status == clarabel.SolverStatus.Solved
        return scaled.answer(np.array(found.z), solved, found.iterations, str(found.status), found.solve_time)

    def _settings(self, **chosen: Any) -> Any:
        """Clarabel's settings: quiet, and without the presolve that would forbid updates."""
        settings = import_module("clarabel").DefaultSettings()
        tuned = _CLARABEL_TUNED if self.settings == "tuned" else {}
        for name, value in {"verbose": False, "presolve_enable": False, **tuned, **chosen}.items():
            setattr(settings, name, value)
        return settings


@solver("osqp", family="relaxation", model="relaxation", warm_start=True, sparse=True, needs=("osqp",), lacks=("asymmetry",))
class OSQP(RelaxationSolver):
    """The convex relaxation as a QP by OSQP itself. (outside)

    Work: iterations.

    Licence: Apache-2.0.
    Clock: OSQP's own solve_time.
    Settings: its defaults.
    Tolerance: eps_abs = eps/10 for both residuals and the gap, eps_rel = 0, not polished; eps stands for tol.
    Reference: Stellato, Banjac, Goulart, Bemporad and Boyd 2020.
    """

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, problem.qp())
        lower, upper = np.concatenate([np.full(len(scaled.h), -np.inf), scaled.b]), np.concatenate([scaled.h, scaled.b])
        return Prepared(scaled, (scaled.upper, scaled.q, scaled.constraints, lower, upper))

    def create(self, formed: Prepared) -> Any:
        workspace = import_module("osqp").OSQP()
        workspace.setup(*formed.given, verbose=False, eps_rel=0.0)
        return workspace

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        scaled, workspace = prepared
        workspace.update_settings(eps_abs=eps / MARGIN, max_iter=limit or 100_000)
        x, y = np.zeros(len(scaled.q)), np.zeros(len(scaled.h) + len(scaled.b))
        if start is not None:
            y[: len(scaled.h)] = scaled.multipliers(start)
            x = sparse.linalg.spsolve(scaled.P, -scaled.q - scaled.G.T @ y[: len(scaled.h)]) if not len(scaled.b) else x
        workspace.warm_start(x=x, y=y)
        found = workspace.solve(raise_error=False)
        info = found.info
        return scaled.answer(found.y, info.status_val == 1, int(info.iter), info.status, info.solve_time)


@solver(
    "proxsuite",
    family="relaxation",
    model="relaxation",
    warm_start=True,
    sparse=True,
    needs=("proxsuite",),
    lacks=("asymmetry",),
    variants=tuple(f"matrices={kind}{tuned}" for kind in ("sparse", "dense") for tuned in ("", ",settings=tuned")),
)
class ProxSuite(RelaxationSolver):
    """The convex relaxation as a QP by ProxSuite itself. (outside)

    matrices: sparse or dense. settings: default or tuned. Work: iterations.

    Licence: BSD-2-Clause.
    Form: the dimensionless QP (solvers.outside.scaled_program), sparse or dense. Setup: the QP object and its init. Solve: its
        solve.
    Clock: ProxQP's own solve_time.
    Settings: compute_timings and check_duality_gap on. By default eps_primal_inf = eps_dual_inf = 1e-4, with which it calls
        solvable problems infeasible; tuned are 1e-14, `frictionbench solve 'stack[blocks=20,mass_ratio=1000000]' --solver
        'proxsuite' --solver 'proxsuite[settings=tuned]'`.
    Tolerance: eps_abs = eps for both residuals, gap eps^2, no less than 1e-14, which is tested only on request; eps_rel = 0;
        eps stands for tol.
    Reference: Bambade, El-Kazdadi, Taylor and Carpentier 2022.
    """

    matrices: str = "sparse"
    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, problem.qp(), from_free=True)
        P, G, A = (scaled.P, scaled.G, scaled.A) if self.matrices == "sparse" else scaled.dense
        equality = (A, scaled.b) if len(scaled.b) else (None, None)
        return Prepared(scaled, (P, scaled.q, *equality, G, np.full(len(scaled.h), -1e20), scaled.h))

    def create(self, formed: Prepared) -> Any:
        scaled, proxqp = formed.scaled, import_module("proxsuite").proxqp
        qp = getattr(proxqp, self.matrices).QP(len(scaled.q), len(scaled.b), len(scaled.h))
        qp.settings.compute_timings = True
        qp.init(*formed.given)
        return qp

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        proxqp: Any = import_module("proxsuite").proxqp
        scaled, qp = prepared
        settings = qp.settings
        settings.eps_abs, settings.eps_rel, settings.max_iter = eps, 0.0, limit or 10_000
        settings.check_duality_gap, settings.eps_duality_gap_rel = True, 0.0
        settings.eps_duality_gap_abs = gap_tolerance(eps, LEAST_GAP["proxsuite"])
        if self.settings == "tuned":
            settings.eps_primal_inf = settings.eps_dual_inf = _INFEASIBILITY
        if start is None:
            settings.initial_guess = proxqp.InitialGuess.NO_INITIAL_GUESS
            qp.solve()
        else:
            settings.initial_guess = proxqp.InitialGuess.WARM_START
            qp.solve(np.zeros(len(scaled.q)), np.zeros(len(scaled.b)), scaled.multipliers(start))
        info = qp.results.info
        solved = info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
        return scaled.answer(np.array(qp.results.z), solved, info.iter, info.status.name, info.solve_time * 1e-6)


@solver(
    "piqp",
    family="relaxation",
    model="relaxation",
    sparse=True,
    needs=("piqp",),
    lacks=("asymmetry",),
    variants=("matrices=sparse", "matrices=dense"),
)
class PIQP(RelaxationSolver):
    """The convex relaxation as a QP by PIQP itself. (outside)

    matrices: sparse or dense. Work: iterations.

    Licence: BSD-2-Clause.
    Form: the dimensionless QP (solvers.outside.scaled_program), sparse or dense. Setup: the library's object, its ordering and
        scaling. Solve: its solve.
    Clock: PIQP's own solve_time.
    Charged: dense some 60 µs more than a call by hand, twice at 2 contacts: the dimensionless program, as for daqp.
    Settings: compute_timings on.
    Tolerance: eps_abs = eps, gap eps^2, no less than 1e-15; relative tolerances are 0; eps stands for tol.
    Reference: Schwan, Jiang, Kuhn and Jones 2023.
    """

    matrices: str = "sparse"

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, problem.qp(), from_free=True)
        P, G, A = (scaled.P, scaled.G, scaled.A) if self.matrices == "sparse" else scaled.dense
        return Prepared(scaled, (P, scaled.q, *((A, scaled.b) if len(scaled.b) else (None, None)), G, None, scaled.h))

    def create(self, formed: Prepared) -> Any:
        made = getattr(import_module("piqp"), f"{self.matrices.capitalize()}Solver")()
        made.settings.compute_timings = True
        made.setup(*formed.given)
        return made

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        piqp: Any = import_module("piqp")
        scaled, made = prepared
        settings = made.settings
        settings.eps_abs, settings.eps_rel, settings.max_iter = eps, 0.0, limit or 500
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = gap_tolerance(eps, LEAST_GAP["piqp"]), 0.0
        found, result = made.solve(), made.result
        clock, solved = float(result.info.solve_time), found == piqp.PIQP_SOLVED
        return scaled.answer(np.array(result.z_u), solved, int(result.info.iter), found.name, clock)


@solver(
    "scs",
    family="relaxation",
    model="relaxation",
    dimension=(2, 3),
    sparse=True,
    needs=("scs",),
    lacks=("asymmetry",),
)
class SCS(RelaxationSolver):
    """The convex relaxation by SCS itself, with circular cones in space. (outside)

    Work: iterations.

    Licence: MIT.
    Form: the dimensionless program (solvers.outside.scaled_program), A above G, P's upper half. Setup: none, as tolerances are
        set with the problem. Solve: its object, ordering and scaling, and its solve.
    Clock: its setup_time and solve_time.
    Settings: its defaults, without output.
    Tolerance: eps_abs = eps/2 for both residuals and the gap, eps_rel = 0; eps stands for tol. With eps/10 it stalls on tall
        stacks.
    Reference: O'Donoghue, Chu, Parikh and Boyd 2016.
    """

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_relaxation(problem)
        rows = scaled.G if scaled.A is None else sparse.vstack([scaled.A, scaled.G], format="csc")
        data = {"P": scaled.upper, "A": rows, "b": np.concatenate([scaled.b, scaled.h]), "c": scaled.q}
        d = scaled.program.contacts[1]
        cone = {"l": len(scaled.h)} if d == 2 else {"q": [d] * (len(scaled.h) // d)}
        return Prepared(scaled, (data, {"z": len(scaled.b), **cone}))

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        scaled, given = prepared
        chosen = {"verbose": False, "eps_abs": eps / 2, "eps_rel": 0.0, "max_iters": limit or 100_000}
        found = import_module("scs").SCS(*given, **chosen).solve()
        info = found["info"]
        clock = 1e-3 * (info["setup_time"] + info["solve_time"])
        return scaled.answer(found["y"][len(scaled.b) :], info["status_val"] == 1, int(info["iter"]), info["status"], clock)
