"""The convex relaxation by the Python interfaces of Clarabel, OSQP, ProxSuite, PIQP and SCS, as a simulator uses them.

Form: the dimensionless QP (solvers.outside.scaled_program), sparse, or dense with matrices=dense. Setup: the library's object,
    its ordering and scaling. Solve: its solve.
Charged: with joint equations .1 ms at 40 contacts and .3 at 80 for what they hold and the units, which no call by hand needs.
"""

from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer
from frictionbench.solvers.outside import STOPPING_MARGIN
from frictionbench.solvers.outside.scaled_program import ScaledProgram, relaxation_library, scaled_program

Prepared = tuple[ScaledProgram, Any]  # and what the library is given: its arguments, after setup its object

LEAST_GAP = {
    "clarabel": 1e-15,  # with 1e-14 some claims are wrong, with 1e-16 accurate answers are failures: docs/fairness.md
    "proxsuite": 1e-15,  # with 1e-14 some answers on walls are off by 2e-8
    "piqp": 1e-14,  # with 1e-15 it takes 2.6 times as many iterations on 182 problems, with 1e-13 claims are off by 4e-8
}
_GAP_ROUNDING = 4.4e-16  # of a gap's terms: without, PIQP accepts no iterate on some chains, and takes twice as many elsewhere
_PROXQP_OBJECTIVE = 0.03  # times the objective: 16 iterations instead of 25 on 117 problems, 22 instead of 26 on 56 others
_OSQP_TUNED = {"rho": 1.0, "adaptive_rho_interval": 25, "check_termination": 10, "eps_prim_inf": 1e-15, "eps_dual_inf": 1e-15}


def clarabel_options(scaled: ScaledProgram, settings: str, tol: float, limit: int | None) -> dict[str, Any]:
    """Clarabel's tolerances and limit, and if tuned its settings for a program that is already scaled."""
    eps, gap = scaled.tolerances(tol, LEAST_GAP["clarabel"])
    options = {"tol_feas": eps, "tol_gap_abs": gap, "tol_gap_rel": gap, "max_iter": limit or 200}
    if settings == "tuned":
        options |= {"equilibrate_enable": False, "static_regularization_constant": 1e-12, "iterative_refinement_enable": False}
        options["max_step_fraction"] = 0.9 if scaled.contacts[1] == 3 else 0.99
    return options


@relaxation_library("clarabel", dimension=(2, 3), needs=("clarabel",), variants=("settings=default", "settings=tuned"))
class Clarabel:
    """The convex relaxation by Clarabel itself, with circular cones in space. (outside)

    settings: default or tuned. Work: iterations.

    Licence: Apache-2.0.
    Form: the dimensionless program (solvers.outside.scaled_program), tuned with rows and columns alike, A and G stacked, P's
        upper half. Setup: Clarabel's solver object, its ordering and scaling. Solve: its solve. (It has no warm start.)
    Clock: its solve_time, which includes its setup.
    Charged: on stacks of 300 contacts twice the iterations of a call by hand, whose gap of 1e-15 is in J and met sooner; with
        joint equations .1 ms at 40 contacts and .3 at 80 for what they hold and the units.
    Settings: presolve off, which would forbid setting tolerances afterwards. tuned is for programs that are already scaled, as
        these are: equilibrate_enable off, static_regularization_constant = 1e-12 instead of 1e-8 and, as that leaves nothing
        to refine, iterative_refinement_enable off; and on circular cones max_step_fraction = 0.9 instead of 0.99, with which
        the gap reaches its limit more often, `frictionbench solve 'random_bodies[contacts=6,seed=1]' --solver 'clarabel'
        --solver 'clarabel[settings=tuned]'`.
    Tolerance: tol_feas = eps, both gaps eps^2, no less than 1e-15; eps stands for tol.
    Flaws: its gap is the difference of two objectives, which rounding can make 0 before the answer is accurate: some answers
        that it calls Solved are off by a few times 1e-8. Or it stays above eps^2, and it reports failure although the answer
        is accurate, `frictionbench solve 'random_bodies[contacts=2,seed=1]' --solver clarabel`. By default it also calls
        answers Solved that are off by 1e-5, `frictionbench solve 'robot_step[case=adroit_hammer-harsh-099]' --solver
        clarabel`, but not with a static regularisation of 1e-12.
    Reference: Goulart and Chen 2024.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, from_free=True, upper=True, alike=self.settings == "tuned")
        return scaled, (scaled.P, scaled.q, scaled.stacked(), scaled.right)

    def setup(self, formed: Prepared) -> Prepared:
        clarabel: Any = import_module("clarabel")
        scaled, arguments = formed
        rows, flat = len(scaled.h), scaled.contacts[1] == 2
        cones = [clarabel.NonnegativeConeT(rows)] if flat else [clarabel.SecondOrderConeT(3)] * (rows // 3)
        cones = [*cones, clarabel.ZeroConeT(len(scaled.b))] if len(scaled.b) else cones
        return scaled, clarabel.DefaultSolver(*arguments, cones, self._settings(scaled))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        clarabel: Any = import_module("clarabel")
        scaled, library_solver = prepared
        library_solver.update(settings=self._settings(scaled, tol, limit))
        result = library_solver.solve()
        solved = result.status == clarabel.SolverStatus.Solved
        return scaled.answer(np.array(result.z), solved, result.iterations, str(result.status), result.solve_time)

    def _settings(self, scaled: ScaledProgram, tol: float = 1.0, limit: int | None = None) -> Any:
        """Clarabel's settings: quiet, and without the presolve that would forbid updates."""
        settings = import_module("clarabel").DefaultSettings()
        chosen = clarabel_options(scaled, self.settings, tol, limit)
        for name, value in {"verbose": False, "presolve_enable": False, **chosen}.items():
            setattr(settings, name, value)
        return settings


@relaxation_library("osqp", warm_start=True, needs=("osqp",), variants=("", "settings=tuned"))
class OSQP:
    """The convex relaxation as a QP by OSQP itself. (outside)

    settings: default or tuned. Work: iterations.

    Licence: Apache-2.0.
    Form: the dimensionless QP (solvers.outside.scaled_program), sparse, A and G stacked, P's upper half. Setup: OSQP's object,
        its ordering and scaling. Solve: its tolerances, its start, and its solve.
    Clock: OSQP's own solve_time.
    Settings: algebra builtin, as otherwise each object first looks for the packages of two others. rho, the weight of the
        constraints that it begins with, is 0.1 by default and may change every 50 iterations, and it tests its residuals every
        25; tuned are 1, of the size of P and A here, 25 and 10, `frictionbench solve 'pyramid[push=1]' --solver osqp --solver
        'osqp[settings=tuned]'`. eps_prim_inf = eps_dual_inf are 1e-4, tuned 1e-15, as it calls solvable problems infeasible.
    Tolerance: eps_abs = eps/10 for both residuals and the gap, eps_rel = 0, not polished; eps stands for tol.
    Reference: Stellato, Banjac, Goulart, Bemporad and Boyd 2020.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, upper=True)
        return scaled, (scaled.P, scaled.q, scaled.stacked(), scaled.least(-np.inf), scaled.right)

    def setup(self, formed: Prepared) -> Prepared:
        scaled, arguments = formed
        workspace = import_module("osqp").OSQP(algebra="builtin")
        workspace.setup(*arguments, verbose=False, eps_rel=0.0, **(_OSQP_TUNED if self.settings == "tuned" else {}))
        return scaled, workspace

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        scaled, workspace = prepared
        workspace.update_settings(eps_abs=tol * scaled.share / STOPPING_MARGIN, max_iter=limit or 100_000)
        x, y = np.zeros(len(scaled.q)), np.zeros(len(scaled.right))
        if start is not None:
            y[: len(scaled.h)] = scaled.multipliers(start)
            if not len(scaled.b) and scaled.P.diagonal().all():
                P = scaled.P + sparse.triu(scaled.P, 1).T
                x = sparse.linalg.spsolve(P.tocsc(), -scaled.q - scaled.G.T @ y)
        workspace.warm_start(x=x, y=y)
        result = workspace.solve(raise_error=False)
        info = result.info
        return scaled.answer(result.y, info.status_val == 1, int(info.iter), info.status, info.solve_time)


@relaxation_library(
    "proxsuite",
    warm_start=True,
    needs=("proxsuite",),
    variants=tuple(f"matrices={kind}{tuned}" for kind in ("sparse", "dense") for tuned in ("", ",settings=tuned")),
)
class ProxSuite:
    """The convex relaxation as a QP by ProxSuite itself. (outside)

    matrices: sparse or dense. settings: default or tuned. Work: iterations.

    Licence: BSD-2-Clause.
    Clock: ProxQP's own solve_time.
    Settings: compute_timings and check_duality_gap on. By default eps_primal_inf = eps_dual_inf = 1e-4, with which it calls
        solvable problems infeasible; tuned are 1e-14, `frictionbench solve 'stack[blocks=30,push=0.7,friction=0.2]' --solver
        'proxsuite' --solver 'proxsuite[settings=tuned]'`. tuned is without preconditioner, as the QP is scaled already, and
        dense with the backend PrimalDualLDLT. Sparse it is given P and q 33 times smaller; dense it is told if P is diagonal.
    Tolerance: eps_abs = eps/100 for both residuals, as with eps it calls answers solved that are off by 10 tol; gap eps^2, no
        less than 1e-15, which is tested only on request; eps_rel = 0, 4.4e-16 for the gap, for rounding; eps stands for tol.
    Reference: Bambade, El-Kazdadi, Taylor and Carpentier 2022.
    """

    matrices: str = "sparse"
    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Prepared:
        dense = self.matrices == "dense"  # about the free motion it then stalls where contacts are open by far
        scaled = scaled_program(problem, dense, from_free=not dense)
        if not dense:
            scaled.P.data *= _PROXQP_OBJECTIVE
            scaled.q *= _PROXQP_OBJECTIVE
            scaled.unit /= _PROXQP_OBJECTIVE
            scaled.share *= _PROXQP_OBJECTIVE
        return scaled, (scaled.P, scaled.q, *scaled.equations, scaled.G, np.full(len(scaled.h), -1e20), scaled.h)

    def setup(self, formed: Prepared) -> Prepared:
        (scaled, arguments), proxqp = formed, import_module("proxsuite").proxqp
        sizes, tuned = (len(scaled.q), len(scaled.b), len(scaled.h)), self.settings == "tuned"
        if self.matrices == "sparse":
            qp = proxqp.sparse.QP(*sizes)
        else:
            kind = proxqp.dense.HessianType.Diagonal if scaled.diagonal else proxqp.dense.HessianType.Dense
            backend = proxqp.dense.DenseBackend.PrimalDualLDLT if tuned else proxqp.dense.DenseBackend.Automatic
            qp = proxqp.dense.QP(*sizes, False, kind, backend)
        qp.settings.compute_timings = True
        qp.init(*arguments, compute_preconditioner=not tuned)
        return scaled, qp

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        proxqp: Any = import_module("proxsuite").proxqp
        scaled, qp = prepared
        (eps, gap), settings = scaled.tolerances(tol, LEAST_GAP["proxsuite"]), qp.settings
        settings.eps_abs, settings.eps_rel, settings.max_iter = eps / STOPPING_MARGIN**2, 0.0, limit or 10_000
        settings.check_duality_gap, settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = True, gap, _GAP_ROUNDING
        if self.settings == "tuned":
            settings.eps_primal_inf = settings.eps_dual_inf = 1e-14
        settings.initial_guess = proxqp.InitialGuess.WARM_START
        z = np.zeros(len(scaled.h)) if start is None else scaled.multipliers(start)
        qp.solve(np.zeros(len(scaled.q)), np.zeros(len(scaled.b)), z)
        info = qp.results.info
        solved = info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
        return scaled.answer(np.array(qp.results.z), solved, info.iter, info.status.name, info.solve_time * 1e-6)


@relaxation_library("piqp", needs=("piqp",), variants=("matrices=sparse", "matrices=dense"))
class PIQP:
    """The convex relaxation as a QP by PIQP itself. (outside)

    matrices: sparse or dense. Work: iterations.

    Licence: BSD-2-Clause.
    Clock: PIQP's own solve_time.
    Charged: some 10 µs more than a call by hand at 2 contacts with dense matrices, 30 at 20, .1 to .3 ms with the joints of 40
        and 80: the units, and what joints hold.
    Settings: compute_timings on.
    Tolerance: eps_abs = eps, gap eps^2, no less than 1e-14; eps_rel = 0, for the gap 4.4e-16; eps stands for tol.
    Reference: Schwan, Jiang, Kuhn and Jones 2023.
    """

    matrices: str = "sparse"

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, self.matrices == "dense", from_free=True)
        return scaled, (scaled.P, scaled.q, *scaled.equations, scaled.G, None, scaled.h)

    def setup(self, formed: Prepared) -> Prepared:
        scaled, arguments = formed
        library_solver = getattr(import_module("piqp"), f"{self.matrices.capitalize()}Solver")()
        library_solver.settings.compute_timings = True
        library_solver.setup(*arguments)
        return scaled, library_solver

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        piqp: Any = import_module("piqp")
        scaled, library_solver = prepared
        (eps, gap), settings = scaled.tolerances(tol, LEAST_GAP["piqp"]), library_solver.settings
        settings.eps_abs, settings.eps_rel, settings.max_iter = eps, 0.0, limit or 500
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = gap, _GAP_ROUNDING
        status, result = library_solver.solve(), library_solver.result
        clock, solved = float(result.info.solve_time), status == piqp.PIQP_SOLVED
        return scaled.answer(np.array(result.z_u), solved, int(result.info.iter), status.name, clock)


@relaxation_library("scs", dimension=(2, 3), needs=("scs",), variants=("settings=default", "settings=tuned"))
class SCS:
    """The convex relaxation by SCS itself, with circular cones in space. (outside)

    settings: default or tuned. Work: iterations.

    Licence: MIT.
    Form: the dimensionless program (solvers.outside.scaled_program), A above G, P's upper half. Setup: none, as tolerances are
        set with the problem. Solve: its object, ordering and scaling, and its solve.
    Clock: its setup_time and solve_time.
    Settings: without output, with the linear solver QDLDL: left to itself it takes Pardiso where MKL is there, which is slower.
        scale, the weight of the dual residual that it begins with, is 0.1 by default, and its Anderson acceleration uses 10
        steps; tuned are 1, of the size of P and A here, and 6, `frictionbench solve 'pyramid[push=1]' --solver scs --solver
        'scs[settings=tuned]'`.
    Tolerance: eps_abs = eps/2 for both residuals and the gap, eps_rel = 0; eps stands for tol. Tall stacks stall at eps/10.
    Flaws: where contacts are open by far its gap stays above this, and it reports failure although the answer is accurate,
        `frictionbench solve 'robot_step[case=kitchen-hit-314]' --solver scs`.
    Reference: O'Donoghue, Chu, Parikh and Boyd 2016.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Prepared:
        scaled = scaled_program(problem, upper=True)
        rows, d, right = len(scaled.h), scaled.contacts[1], np.concatenate([scaled.b, scaled.h])
        data = {"P": scaled.P, "A": scaled.stacked(joints_first=True), "b": right, "c": scaled.q}
        cone = {"l": rows} if d == 2 else {"q": [d] * (rows // d)}
        return scaled, (data, {"z": len(scaled.b), **cone})

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        scaled, arguments = prepared
        accuracy = {"eps_abs": tol * scaled.share / 2, "eps_rel": 0.0, "max_iters": limit or 100_000}
        tuned = {"scale": 1.0, "acceleration_lookback": 6} if self.settings == "tuned" else {}
        scs: Any = import_module("scs")
        result = scs.SCS(*arguments, linear_solver=scs.LinearSolver.QDLDL, verbose=False, **tuned, **accuracy).solve()
        info = result["info"]
        clock = 1e-3 * (info["setup_time"] + info["solve_time"])
        return scaled.answer(result["y"][len(scaled.b) :], info["status_val"] == 1, int(info["iter"]), info["status"], clock)
