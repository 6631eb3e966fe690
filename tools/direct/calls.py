"""Calls of outside libraries as a user would write them by hand, with which the adapters of frictionbench are compared.

They do not use the adapters. Each forms its library's input with numpy and scipy from a problem's arrays, without scaling, and
returns the contact impulses and whether the library reports success (tools.direct.arrays).
"""

import json
import subprocess
from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from timeit import repeat
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from tools.direct.arrays import Arrays, Called, delassus, dense, lcp, of_lcp, of_multipliers, program, with_joints


def clarabel(problem: Arrays, tol: float) -> Called:
    library: Any = import_module("clarabel")
    P, q, G, h = program(problem)
    (C, c, joints), settings, n = with_joints(problem, G, h), library.DefaultSettings(), len(h)
    settings.verbose, settings.tol_feas, settings.tol_gap_abs, settings.tol_gap_rel = False, tol, 1e-15, 1e-15
    cones = [library.NonnegativeConeT(n)] if problem.d == 2 else [library.SecondOrderConeT(3)] * (n // 3)
    cones = [*cones, library.ZeroConeT(joints)] if joints else cones
    found = library.DefaultSolver(_upper(P), q, sparse.csc_matrix(C), c, cones, settings).solve()
    return Called(of_multipliers(problem, np.array(found.z)), found.status == library.SolverStatus.Solved)


def scs(problem: Arrays, tol: float, **chosen: float) -> Called:
    library: Any = import_module("scs")
    P, q, G, h = program(problem)
    C, c, joints = with_joints(problem, G, h, first=True)
    cone = {"z": joints} | ({"l": len(h)} if problem.d == 2 else {"q": [3] * (len(h) // 3)})
    data = {"P": _upper(P), "A": sparse.csc_matrix(C), "b": c, "c": q}
    settings = {"eps_abs": tol / 10, "eps_rel": 0.0, "linear_solver": library.LinearSolver.QDLDL, **chosen}
    found = library.SCS(data, cone, verbose=False, max_iters=100_000, **settings).solve()
    return Called(of_multipliers(problem, found["y"][joints:]), found["info"]["status_val"] == 1)


def osqp(problem: Arrays, tol: float, **chosen: float) -> Called:
    library: Any = import_module("osqp")
    P, q, G, h = program(problem)
    made = library.OSQP(algebra="builtin")
    (C, c, _), settings = with_joints(problem, G, h), {"verbose": False, "max_iter": 100_000, **chosen}
    lower = np.concatenate([np.full(len(h), -np.inf), c[len(h) :]])
    made.setup(_upper(P), q, sparse.csc_matrix(C), lower, c, eps_abs=tol / 10, eps_rel=0.0, **settings)
    found = made.solve(raise_error=False)
    return Called(of_multipliers(problem, found.y), found.info.status_val == 1)


def _upper(P: Any) -> Any:
    return sparse.triu(sparse.csc_matrix(P), format="csc")


def proxsuite(problem: Arrays, tol: float) -> Called:
    library: Any = import_module("proxsuite").proxqp
    P, q, G, h = program(problem)
    qp = library.sparse.QP(len(q), len(problem.f), len(h))
    joints = (sparse.csc_matrix(problem.F), problem.f) if len(problem.f) else (None, None)
    settings = qp.settings
    settings.eps_abs, settings.eps_rel, settings.check_duality_gap = tol, 0.0, True
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = 1e-14, 0.0
    settings.initial_guess = library.InitialGuess.NO_INITIAL_GUESS
    qp.init(sparse.csc_matrix(P), q, *joints, sparse.csc_matrix(G), np.full(len(h), -1e20), h)
    qp.solve()
    solved = qp.results.info.status == library.QPSolverOutput.PROXQP_SOLVED
    return Called(of_multipliers(problem, np.array(qp.results.z)), solved)


def piqp(problem: Arrays, tol: float, matrices: str = "sparse") -> Called:
    library: Any = import_module("piqp")
    P, q, G, h = program(problem)
    made, kept = (library.SparseSolver(), sparse.csc_matrix) if matrices == "sparse" else (library.DenseSolver(), dense)
    settings = made.settings
    settings.eps_abs, settings.eps_rel = tol, 0.0
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = 1e-15, 0.0
    joints = (kept(problem.F), problem.f) if len(problem.f) else (None, None)
    made.setup(kept(P), q, *joints, kept(G), None, h)
    found = made.solve()
    return Called(of_multipliers(problem, np.array(made.result.z_u)), found == library.PIQP_SOLVED)


def daqp(problem: Arrays, tol: float) -> Called:
    library: Any = import_module("daqp")
    P, q, G, h = program(problem)
    rows: tuple[Any, ...] = dense(P), q, dense(G), h
    if len(problem.f):
        C, c, _ = with_joints(problem, G, h)
        sense, lower = np.zeros(len(c), dtype=np.int32), np.full(len(c), -1e30)
        sense[len(h) :], lower[len(h) :] = 5, c[len(h) :]  # DAQP's mark of an equation
        rows = dense(P), q, dense(C), c, lower, sense
    _, _, flag, info = library.solve(*rows, primal_tol=tol / 10, dual_tol=tol / 10, iter_limit=10_000)
    return Called(of_multipliers(problem, np.array(info["lam"])), flag > 0)


def quadprog(problem: Arrays, tol: float) -> Called:
    library: Any = import_module("quadprog")
    P, q, G, h = program(problem)
    C, c, joints = with_joints(problem, G, h, first=True)
    return Called(of_multipliers(problem, library.solve_qp(dense(P), -q, -dense(C).T, -c, joints)[4][joints:]), True)


def highs(problem: Arrays, tol: float, **settings: Any) -> Called:
    feasible = dict.fromkeys(("primal_feasibility_tolerance", "dual_feasibility_tolerance"), max(tol / 10, 1e-10))
    library: Any = import_module("qpsolvers")
    P, q, G, h = program(problem)
    joints = (sparse.csc_matrix(problem.F), problem.f) if len(problem.f) else (None, None)
    asked = library.Problem(sparse.csc_matrix(P), q, sparse.csc_matrix(G), h, *joints)
    # as solve_problem, whose own argument `solver` would hide HiGHS' option
    found = import_module("qpsolvers.solvers").solve_function["highs"](asked, **feasible, **settings)
    return Called(of_multipliers(problem, np.zeros(len(h)) if found.z is None else found.z), found.found)


def quantecon(problem: Arrays, tol: float) -> Called:
    lemke: Any = import_module("quantecon.optimize.lcp_lemke").lcp_lemke
    M, q = lcp(problem)
    found = lemke(M, q)
    return Called(of_lcp(problem, found.z), found.success)


def casadi(problem: Arrays, tol: float) -> Called:
    M, q = lcp(problem)
    made = _ipopt(len(q), tol)
    found = made(x0=0.0, lbx=0.0, lbg=0.0, ubg=0.0, p=np.concatenate([M.ravel("F"), q]))
    return Called(of_lcp(problem, np.array(found["x"]).ravel()[: len(q)]), made.stats()["success"])


@cache
def _ipopt(n: int, tol: float) -> Any:
    library: Any = import_module("casadi")
    z, w, M, q = (library.MX.sym(name, *size) for name, *size in (("z", n), ("w", n), ("M", n, n), ("q", n)))
    options = {"print_level": 0, "sb": "yes", "tol": max(tol**2, 1e-14), "bound_relax_factor": 0.0}
    program = {"x": library.veccat(z, w), "p": library.veccat(M, q), "f": library.dot(z, w), "g": M @ z + q - w}
    return library.nlpsol("made", "ipopt", program, {"ipopt": options, "print_time": False})


def drake(problem: Arrays, tol: float) -> Called:
    library: Any = import_module("pydrake.solvers")
    M, q = lcp(problem)
    program = library.MathematicalProgram()
    z = program.NewContinuousVariables(len(q))
    program.AddLinearComplementarityConstraint(M, q, z)
    found = library.UnrevisedLemkeSolver().Solve(program, None, None)
    return Called(of_lcp(problem, found.GetSolution(z)), found.is_success())


def pinocchio(problem: Arrays, tol: float, **chosen: float) -> Called:
    pin: Any = import_module("pinocchio")
    nc, d = len(problem.mu), problem.d
    own = (3 * np.arange(nc)[:, None] + np.array([2, 0, 1])[:d]).ravel()
    matrix, vector = delassus(problem)
    W, g = np.zeros((3 * nc, 3 * nc), order="F"), np.zeros(3 * nc)
    W[np.ix_(own, own)], g[own] = dense(matrix), vector
    if d == 2:  # a second tangent, decoupled
        W[3 * np.arange(nc) + 1, 3 * np.arange(nc) + 1] = W[3 * np.arange(nc), 3 * np.arange(nc)]
    body = pin.Model()
    body.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for mu in problem.mu:
        point = pin.PointContactConstraintModel(body, 0, pin.SE3.Identity(), 1, pin.SE3.Identity())
        point.setFriction(mu)
        model = pin.ConstraintModel(point)
        models.append(model)
        datas.append(model.createData())
    settings, result = pin.ADMMSolverSettings(), pin.ADMMSolverResult()
    settings.max_iterations = 20_000
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = tol / 10
    settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
    for option, value in chosen.items():
        setattr(settings, option, value)
    found = pin.ADMMConstraintSolver().solve(pin.DelassusOperatorDense(W), g, models, datas, settings, result)
    return Called(np.array(result.retrieveConstraintImpulses())[own].reshape(nc, d), found)


def mujoco(problem: Arrays, tol: float) -> Called:
    library: Any = import_module("mujoco")
    (nc, nv, d), L = (len(problem.mu), len(problem.v), problem.d), np.linalg.cholesky(dense(problem.M))
    _, _, G, h = program(problem)
    J, b, directions = (dense(problem.J), problem.b, 3) if d == 3 else (-dense(G), h, 1)  # pyramids, as frictionless contacts
    scale = np.square(np.linalg.solve(L, dense(problem.J).T)).sum(axis=0).reshape(nc, d).mean(axis=1)
    soft = max(tol, 1e-7) * np.ones((nc, 3)) if d == 3 else max(tol, 1e-6) * np.minimum(1, problem.mu[:, None] ** [2, -2])
    model, data = _soft_contacts(nv, len(b) // directions, directions)
    model.opt.iterations, model.opt.tolerance = 1000, 0.0 if d == 3 else 1e-30
    data.efc_J[:], data.efc_aref[:] = np.linalg.solve(L, J.T).T.ravel(), -b
    data.efc_R[:] = (scale[:, None] * (soft if d == 3 else 2 * soft[:, [0, 0]])).ravel()
    data.efc_D[:] = 1 / data.efc_R
    data.efc_margin[:] = data.efc_pos[:] = 0
    if d == 3:  # a contact whose elliptic cone has no friction is left out
        data.contact.mu[:] = data.contact.friction[:, 0] = data.contact.friction[:, 1] = np.maximum(problem.mu, 1e-8)
    data.qacc_smooth[:] = data.qfrc_smooth[:] = L.T @ problem.v
    library.mj_fwdConstraint(model, data)
    impulse = data.efc_force.reshape(nc, 3).copy() if d == 3 else of_multipliers(problem, data.efc_force)
    return Called(impulse, data.solver_niter[0] < 1000, softness=scale[:, None] * soft)


@cache
def _soft_contacts(nv: int, nc: int, directions: int) -> tuple[Any, Any]:
    """Make a MuJoCo model of nv bodies of unit mass on slides and nc contacts, whose rows are then overwritten."""
    library: Any = import_module("mujoco")
    spheres = "".join(f'<geom type="sphere" size=".1" pos="{j} 0 .0999" contype="1" conaffinity="0"/>' for j in range(nc))
    slide = '<joint type="slide" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    bodies = "".join(f"<body>{slide}{'' if i else spheres}</body>" for i in range(nv))
    model = library.MjModel.from_xml_string(
        '<mujoco><option gravity="0 0 0" cone="elliptic" impratio="1" jacobian="dense" solver="Newton">'
        f'<flag warmstart="disable" island="disable"/></option><default><geom condim="{directions}"/></default><worldbody>'
        f'<geom type="plane" size="9999 9999 .1" contype="0" conaffinity="1"/>{bodies}</worldbody></mujoco>'
    )
    data = library.MjData(model)
    library.mj_forward(model, data)
    return model, data


def siconos(problem: Arrays, tol: float, method: str) -> Called:
    """Call Siconos in a child process with the system's Python, for which Debian builds it."""
    W, q = delassus(problem)
    forming = min(repeat(lambda: delassus(problem), number=1, repeat=20))
    W = sparse.coo_array(W)
    entries = np.column_stack([W.row, W.col, W.data])
    asked = {"entries": entries.tolist(), "q": q.tolist(), "mu": problem.mu.tolist(), "tol": tol, "method": method}
    script = Path(__file__).with_name("siconos_child.py")
    done = subprocess.run(["/usr/bin/python3", script], input=json.dumps(asked), capture_output=True, text=True, check=True)
    found = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))
    return Called(np.reshape(found["r"], (-1, problem.d)), not found["code"], forming + found["clock"])


class Call(NamedTuple):
    """A call by hand. d: the dimensions that it accepts; most: the number of contacts above which it takes seconds; by_matrix:
    whether it accepts problems given only by W and q; joints: whether it ends on problems with joint equations."""

    function: Callable[[Arrays, float], Called]
    d: tuple[int, ...] = (2,)
    most: int = 300
    by_matrix: bool = False
    joints: bool = True


# The variant of each adapter, and the call by hand with the same choices.
CALLS: dict[str, Call] = {
    "clarabel[settings=default]": Call(clarabel, (2, 3)),
    "osqp": Call(osqp),
    "osqp[settings=tuned]": Call(partial(osqp, rho=1.0, adaptive_rho_interval=25, check_termination=10)),
    "scs[settings=default]": Call(scs, (2, 3)),
    "scs[settings=tuned]": Call(partial(scs, scale=1.0, acceleration_lookback=6), (2, 3)),
    "proxsuite[matrices=sparse]": Call(proxsuite),
    "piqp[matrices=sparse]": Call(piqp),
    "piqp[matrices=dense]": Call(partial(piqp, matrices="dense")),
    "daqp": Call(daqp),
    "quadprog": Call(quadprog),
    "ccp[backend=highs]": Call(highs, joints=False),
    "ccp[backend=highs,settings=tuned]": Call(partial(highs, qp_regularization_value=0.0), joints=False),
    "ccp[backend=hipo]": Call(partial(highs, solver="hipo", ipm_optimality_tolerance=1e-12)),
    "quantecon[settings=default]": Call(quantecon, by_matrix=True),
    "casadi[settings=tuned]": Call(casadi, most=100, by_matrix=True),
    "drake[method=unrevised]": Call(drake, most=20, by_matrix=True),
    "pinocchio[method=admm]": Call(pinocchio, (2, 3), 100, by_matrix=True),
    "pinocchio[method=admm,settings=tuned]": Call(
        partial(pinocchio, anderson_capacity=8, lanczos_size=10, max_delassus_decomposition_updates=10), (2, 3), by_matrix=True
    ),
    "mujoco[method=newton]": Call(mujoco, (2, 3), 100),
    "siconos[method=friction_2d_nsgs]": Call(partial(siconos, method="FRICTION_2D_NSGS"), most=20, by_matrix=True),
    "siconos[method=friction_3d_nsgs]": Call(partial(siconos, method="FRICTION_3D_NSGS"), (3,), by_matrix=True),
    "siconos[method=friction_3d_prox]": Call(partial(siconos, method="FRICTION_3D_PROX"), (3,), by_matrix=True),
}
