"""Calls of outside libraries as a user would write them by hand, with which the adapters of frictionbench are compared.

They know nothing of the adapters: each forms what its library takes with numpy from the dense arrays of a problem, unscaled,
and returns the contact impulses and whether the library reports success (tools.direct.given).
"""

import io
import json
import re
import subprocess
import warnings
from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy import sparse

from tools.direct.given import Arrays, Called, delassus, lcp, of_lcp, of_multipliers, program


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
    upper, lower, settings = sparse.csc_matrix(np.triu(P)), np.full(len(h), -np.inf), {"verbose": False, "max_iter": 100_000}
    made.setup(upper, q, sparse.csc_matrix(G), lower, h, eps_abs=tol / 10, eps_rel=0.0, **settings)
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


def clarabel_by_qpsolvers(given: Arrays, tol: float) -> Called:
    return _by_qpsolvers(given, "clarabel", tol_feas=tol, tol_gap_abs=1e-16, tol_gap_rel=1e-16)


def highs(given: Arrays, tol: float, **settings: float) -> Called:
    feasible = dict.fromkeys(("primal_feasibility_tolerance", "dual_feasibility_tolerance"), max(tol / 10, 1e-10))
    return _by_qpsolvers(given, "highs", **feasible, **settings)


def _by_qpsolvers(given: Arrays, backend: str, **settings: float) -> Called:
    library: Any = import_module("qpsolvers")
    P, q, G, h = program(given)
    asked = library.Problem(sparse.csc_matrix(P), q, sparse.csc_matrix(G), h)
    found = library.solve_problem(asked, backend, **settings)
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


def quantecon(given: Arrays, tol: float) -> Called:
    lemke: Any = import_module("quantecon.optimize.lcp_lemke").lcp_lemke
    M, q = lcp(given)
    found = lemke(M, q)
    return Called(of_lcp(found.z), found.success)


def drake(given: Arrays, tol: float) -> Called:
    library: Any = import_module("pydrake.solvers")
    M, q = lcp(given)
    program = library.MathematicalProgram()
    z = program.NewContinuousVariables(len(q))
    program.AddLinearComplementarityConstraint(M, q, z)
    found = library.UnrevisedLemkeSolver().Solve(program, None, None)
    return Called(of_lcp(found.GetSolution(z)), found.is_success())


def path(given: Arrays, tol: float) -> Called:
    gp: Any = import_module("gamspy")
    begun = perf_counter()
    M, q = lcp(given)
    forming = perf_counter() - begun
    model, parameters, z = _gams_model(len(q))
    for symbol, values in zip(parameters, (M, q), strict=True):
        symbol.setRecords(values)
    z.setRecords(np.zeros(len(q)))
    log = io.StringIO()
    options = {"convergence_tolerance": tol / 10}
    model.solve(solver="path", solver_options=options, output=log, options=gp.Options(solve_link_type="memory"))
    clock = re.search(r"Total Time[. ]*([\d.]+)", log.getvalue())
    claimed = model.status.name in ("OptimalGlobal", "OptimalLocal")
    return Called(of_lcp(z.records["level"].to_numpy()), claimed, forming + float(clock[1]) if clock else None)


@cache
def _gams_model(n: int) -> tuple[Any, tuple[Any, Any], Any]:
    """GAMSPy's model of an LCP of n unknowns, the parameters M and q, and z."""
    gp: Any = import_module("gamspy")
    gp.set_options({"ALLOW_AMBIGUOUS_EQUATIONS": "yes"})
    made = gp.Container()
    i = gp.Set(made, "i", records=[str(k) for k in range(n)])
    j = gp.Alias(made, "j", alias_with=i)
    M, q = gp.Parameter(made, "M", domain=[i, j]), gp.Parameter(made, "q", domain=[i])
    z, w = gp.Variable(made, "z", type="positive", domain=[i]), gp.Equation(made, "w", domain=[i])
    w[i] = gp.Sum(j, M[i, j] * z[j]) + q[i] >= 0
    return gp.Model(made, "lcp", problem="MCP", matches={w: z}), (M, q), z


def pinocchio(given: Arrays, tol: float) -> Called:
    pin: Any = import_module("pinocchio")
    nc = len(given.mu)
    own = np.column_stack([3 * np.arange(nc) + 2, 3 * np.arange(nc)]).ravel()
    W, g = np.zeros((3 * nc, 3 * nc), order="F"), np.zeros(3 * nc)
    W[np.ix_(own, own)], g[own] = delassus(given)
    W[own[1::2] + 1, own[1::2] + 1] = W[own[1::2], own[1::2]]
    body = pin.Model()
    body.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for mu in given.mu:
        point = pin.PointContactConstraintModel(body, 0, pin.SE3.Identity(), 1, pin.SE3.Identity())
        point.setFriction(mu)
        model = pin.ConstraintModel(point)
        models.append(model)
        datas.append(model.createData())
    settings, result = pin.ADMMSolverSettings(), pin.ADMMSolverResult()
    settings.max_iterations = 20_000
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = tol / 10
    settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
    found = pin.ADMMConstraintSolver().solve(pin.DelassusOperatorDense(W), g, models, datas, settings, result)
    return Called(np.array(result.retrieveConstraintImpulses())[own].reshape(nc, 2), found)


def mujoco(given: Arrays, tol: float) -> Called:
    library: Any = import_module("mujoco")
    M, N, T, v, b, mu = given
    nc, nv = len(mu), len(v)
    model, data = _soft_contacts(nv, nc)
    L, J, offset = np.linalg.cholesky(M), np.zeros((3 * nc, nv)), np.zeros(3 * nc)
    J[0::3], J[1::3], offset[0::3] = np.linalg.solve(L, N.T).T, np.linalg.solve(L, T.T).T, b
    scale = (np.square(J[0::3]).sum(axis=1) + np.square(J[1::3]).sum(axis=1)) / 2
    model.opt.iterations, softness = 1000, np.repeat(max(tol, 1e-7) * scale, 3)
    data.efc_J[:], data.efc_aref[:], data.efc_R[:], data.efc_D[:] = J.ravel(), -offset, softness, 1 / softness
    data.efc_margin[:] = data.efc_pos[:] = 0
    data.contact.mu[:], data.contact.friction[:, :2] = mu, mu[:, None]
    data.qacc_smooth[:] = data.qfrc_smooth[:] = L.T @ v
    library.mj_fwdConstraint(model, data)
    return Called(data.efc_force.reshape(nc, 3)[:, :2].copy(), data.solver_niter[0] < 1000)


@cache
def _soft_contacts(nv: int, nc: int) -> tuple[Any, Any]:
    """A MuJoCo model of nv bodies of unit mass on slides and nc contacts, whose rows are then overwritten."""
    library: Any = import_module("mujoco")
    spheres = "".join(f'<geom type="sphere" size=".1" pos="{j} 0 .0999" contype="1" conaffinity="0"/>' for j in range(nc))
    slide = '<joint type="slide" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    bodies = "".join(f"<body>{slide}{'' if i else spheres}</body>" for i in range(nv))
    model = library.MjModel.from_xml_string(
        '<mujoco><option gravity="0 0 0" cone="elliptic" impratio="1" jacobian="dense" tolerance="0" solver="Newton">'
        '<flag warmstart="disable" island="disable"/></option><default><geom condim="3"/></default><worldbody>'
        f'<geom type="plane" size="9999 9999 .1" contype="0" conaffinity="1"/>{bodies}</worldbody></mujoco>'
    )
    data = library.MjData(model)
    library.mj_forward(model, data)
    return model, data


def siconos(given: Arrays, tol: float) -> Called:
    """By a child of the system's Python, for which Debian builds Siconos."""
    asked = {field: value.tolist() for field, value in given._asdict().items()} | {"tol": tol}
    script = Path(__file__).with_name("siconos_child.py")
    done = subprocess.run(["/usr/bin/python3", script], input=json.dumps(asked), capture_output=True, text=True, check=True)
    found = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))
    return Called(np.reshape(found["r"], (-1, 2)), not found["code"], found["clock"])


# The variant of an adapter, and the call by hand that makes the same choices.
CALLS: dict[str, Callable[[Arrays, float], Called]] = {
    "clarabel[settings=default]": clarabel,
    "osqp": osqp,
    "proxsuite[matrices=sparse]": proxsuite,
    "piqp": piqp,
    "daqp": daqp,
    "quadprog": quadprog,
    "qpmad": qpmad,
    "ccp[backend=clarabel]": clarabel_by_qpsolvers,
    "ccp[backend=highs]": highs,
    "ccp[backend=highs,settings=tuned]": partial(highs, qp_regularization_value=0.0),
    "ccp_cone[backend=clarabel]": cvxpy,
    "casadi[method=qrqp]": casadi_qrqp,
    "mujoco_boxqp[settings=default]": mujoco_boxqp,
    "quantecon[settings=default]": quantecon,
    "drake[method=unrevised]": drake,
    "path": path,
    "pinocchio[method=admm]": pinocchio,
    "mujoco[method=newton]": mujoco,
    "siconos[method=friction_2d_nsgs]": siconos,
}
