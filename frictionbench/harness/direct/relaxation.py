"""Calls by hand of libraries of quadratic programs, on the convex relaxation in the velocities or its dual."""

import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.harness.direct.given import Arrays, Called, of_multipliers, program


def clarabel(given: Arrays, tol: float) -> Called:
    library: Any = import_module("clarabel")
    P, q, G, h = program(given)
    settings = library.DefaultSettings()
    settings.verbose, settings.tol_feas, settings.tol_gap_abs, settings.tol_gap_rel = False, tol, 1e-16, 1e-16
    upper, bounds = sparse.csc_matrix(np.triu(P)), sparse.csc_matrix(G)
    found = library.DefaultSolver(upper, q, bounds, h, [library.NonnegativeConeT(len(h))], settings).solve()
    return Called(of_multipliers(given, np.array(found.z)), found.status == library.SolverStatus.Solved)


def osqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("osqp")
    P, q, G, h = program(given)
    made = library.OSQP()
    lower = np.full(len(h), -np.inf)
    made.setup(
        sparse.csc_matrix(np.triu(P)),
        q,
        sparse.csc_matrix(G),
        lower,
        h,
        verbose=False,
        eps_abs=tol / 10,
        eps_rel=0.0,
        max_iter=100_000,
    )
    found = made.solve(raise_error=False)
    return Called(of_multipliers(given, found.y), found.info.status_val == 1)


def proxsuite(given: Arrays, tol: float) -> Called:
    library: Any = import_module("proxsuite").proxqp
    P, q, G, h = program(given)
    qp = library.sparse.QP(len(q), 0, len(h))
    settings = qp.settings
    settings.eps_abs, settings.eps_rel, settings.check_duality_gap = tol, 0.0, True
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = 1e-14, 0.0
    settings.initial_guess = library.InitialGuess.NO_INITIAL_GUESS
    qp.init(sparse.csc_matrix(P), q, None, None, sparse.csc_matrix(G), np.full(len(h), -1e20), h)
    qp.solve()
    solved = qp.results.info.status == library.QPSolverOutput.PROXQP_SOLVED
    return Called(of_multipliers(given, np.array(qp.results.z)), solved)


def piqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("piqp")
    P, q, G, h = program(given)
    made = library.SparseSolver()
    settings = made.settings
    settings.eps_abs, settings.eps_rel = tol, 0.0
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = 3e-16, 0.0
    made.setup(sparse.csc_matrix(P), q, None, None, sparse.csc_matrix(G), None, h)
    found = made.solve()
    return Called(of_multipliers(given, np.array(made.result.z_u)), found == library.PIQP_SOLVED)


def daqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("daqp")
    P, q, G, h = program(given)
    sense = np.zeros(len(h), dtype=np.int32)
    _, _, flag, info = library.solve(P, q, G, h, np.full(len(h), -1e30), sense, primal_tol=tol / 10, dual_tol=tol / 10)
    return Called(of_multipliers(given, np.array(info["lam"])), flag > 0)


def quadprog(given: Arrays, tol: float) -> Called:
    library: Any = import_module("quadprog")
    P, q, G, h = program(given)
    return Called(of_multipliers(given, library.solve_qp(P, -q, -G.T, -h)[4]), True)


def mujoco_boxqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("mujoco")
    P, q, G, h = program(given)
    H, g = G @ np.linalg.solve(P, G.T), h + G @ np.linalg.solve(P, q)
    n = len(g)
    H[np.diag_indices(n)] *= 1 + 1e-13
    z, factor, index = np.zeros((n, 1)), np.zeros((n, n + 7)), np.zeros((n, 1), dtype=np.int32)
    rank = library.mju_boxQP(z, factor, index, H, g[:, None], np.zeros((n, 1)), None)
    return Called(of_multipliers(given, z.ravel()), rank >= 0)


def qpmad(given: Arrays, tol: float) -> Called:
    library: Any = import_module("pyqpmad")
    P, q, G, h = program(given)
    made, multipliers = library.Solver(), np.zeros(len(h))
    code = made.solve(np.zeros(len(q)), np.array(P, order="F"), q, None, None, G, np.full(len(h), -1e30), h)
    active = made.get_inequality_dual()
    multipliers[active.indices] = active.dual
    return Called(of_multipliers(given, multipliers), code == library.OK)


def qpsolvers(given: Arrays, tol: float, backend: str = "clarabel", **settings: Any) -> Called:
    library: Any = import_module("qpsolvers")
    P, q, G, h = program(given)
    asked = library.Problem(sparse.csc_matrix(P), q, sparse.csc_matrix(G), h)
    found = library.solve_problem(asked, backend, **_ACCURATE[backend](tol), **settings)
    return Called(of_multipliers(given, np.zeros(len(h)) if found.z is None else found.z), found.found)


def cvxpy(given: Arrays, tol: float) -> Called:
    library: Any = import_module("cvxpy")
    P, q, G, h = program(given)
    v = library.Variable(len(q))
    rows = G @ v <= h
    asked = library.Problem(library.Minimize(library.quad_form(v, P, assume_PSD=True) / 2 + q @ v), [rows])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of an inaccurate solution; the status reports it
        asked.solve(solver="CLARABEL", tol_feas=tol, tol_gap_abs=1e-16, tol_gap_rel=1e-16)
    return Called(of_multipliers(given, rows.dual_value), asked.status == "optimal")


def casadi_qrqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("casadi")
    P, q, G, h = program(given)
    H, g = G @ np.linalg.solve(P, G.T), h + G @ np.linalg.solve(P, q)
    n = len(g)
    H[np.diag_indices(n)] *= 1 + 1e-12
    silent = {"print_iter": False, "print_header": False, "print_info": False, "error_on_fail": False}
    sparsity = {"h": library.Sparsity.dense(n, n), "a": library.Sparsity(0, n)}
    made = library.conic("solver", "qrqp", sparsity, silent)
    found = made(h=H, g=g, lbx=0.0, ubx=np.inf)
    return Called(of_multipliers(given, np.array(found["x"]).ravel()), made.stats()["success"])


_ACCURATE: dict[str, Callable[[float], dict[str, Any]]] = {
    "clarabel": lambda tol: {"tol_feas": tol, "tol_gap_abs": 1e-16, "tol_gap_rel": 1e-16},
    "highs": lambda tol: dict.fromkeys(("primal_feasibility_tolerance", "dual_feasibility_tolerance"), max(tol / 10, 1e-10)),
}
