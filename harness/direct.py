"""Calls of outside libraries as a user would write them by hand, with which the adapters of solvers.outside are compared.

They know nothing of the adapters: a problem in the plane is the dense arrays M (nv, nv), N and T (nc, nv), v* (nv,), b (nc,)
and mu (nc,), which a user of the library has at hand; each call forms what its library takes with numpy, unscaled, and returns
the contact impulses (nc, 2) and whether the library reports success. The friction LCP is

    z = (c, beta+, beta-, lambda),      w = [W G + e lambda; mu c - beta+ - beta-] + q,

and the relaxation's QP is min ½ v'Mv - (M v*)'v with C v + b >= 0, two rows N_i + mu_i T_i and N_i - mu_i T_i a contact.
"""

import io
import re
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.outside.children.child import child
from frictionbench.solvers.outside.siconos import PYTHON


class Arrays(NamedTuple):
    """A problem in the plane, without joints and friction bias."""

    M: Array
    N: Array
    T: Array
    v: Array
    b: Array
    mu: Array


class Called(NamedTuple):
    """What a call returns: impulse (nc, 2), N s; whether the library claims success; its own time where it needs a child, s."""

    impulse: Array
    claimed: bool
    clock: float | None = None


def arrays(problem: FrictionProblem) -> Arrays:
    """The dense arrays of a problem."""
    M, N, T = problem.mass.toarray(), problem.normal.toarray(), problem.tangent.toarray()
    return Arrays(M, N, T, problem.free_velocity.copy(), problem.bias.copy(), problem.friction.copy())


def clarabel(given: Arrays, tol: float) -> Called:
    library: Any = import_module("clarabel")
    P, q, G, h = _qp(given)
    settings = library.DefaultSettings()
    settings.verbose, settings.tol_feas, settings.tol_gap_abs, settings.tol_gap_rel = False, tol, 1e-16, 1e-16
    upper, bounds = sparse.csc_matrix(np.triu(P)), sparse.csc_matrix(G)
    found = library.DefaultSolver(upper, q, bounds, h, [library.NonnegativeConeT(len(h))], settings).solve()
    return Called(_impulses(given, np.array(found.z)), found.status == library.SolverStatus.Solved)


def osqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("osqp")
    P, q, G, h = _qp(given)
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
    return Called(_impulses(given, found.y), found.info.status_val == 1)


def proxsuite(given: Arrays, tol: float) -> Called:
    library: Any = import_module("proxsuite").proxqp
    P, q, G, h = _qp(given)
    qp = library.sparse.QP(len(q), 0, len(h))
    settings = qp.settings
    settings.eps_abs, settings.eps_rel, settings.check_duality_gap = tol, 0.0, True
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = 1e-14, 0.0
    settings.initial_guess = library.InitialGuess.NO_INITIAL_GUESS
    qp.init(sparse.csc_matrix(P), q, None, None, sparse.csc_matrix(G), np.full(len(h), -1e20), h)
    qp.solve()
    solved = qp.results.info.status == library.QPSolverOutput.PROXQP_SOLVED
    return Called(_impulses(given, np.array(qp.results.z)), solved)


def piqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("piqp")
    P, q, G, h = _qp(given)
    made = library.SparseSolver()
    settings = made.settings
    settings.eps_abs, settings.eps_rel = tol, 0.0
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = 3e-16, 0.0
    made.setup(sparse.csc_matrix(P), q, None, None, sparse.csc_matrix(G), None, h)
    found = made.solve()
    return Called(_impulses(given, np.array(made.result.z_u)), found == library.PIQP_SOLVED)


def daqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("daqp")
    P, q, G, h = _qp(given)
    sense = np.zeros(len(h), dtype=np.int32)
    _, _, flag, info = library.solve(P, q, G, h, np.full(len(h), -1e30), sense, primal_tol=tol / 10, dual_tol=tol / 10)
    return Called(_impulses(given, np.array(info["lam"])), flag > 0)


def quadprog(given: Arrays, tol: float) -> Called:
    library: Any = import_module("quadprog")
    P, q, G, h = _qp(given)
    return Called(_impulses(given, library.solve_qp(P, -q, -G.T, -h)[4]), True)


def mujoco_boxqp(given: Arrays, tol: float) -> Called:
    library: Any = import_module("mujoco")
    P, q, G, h = _qp(given)
    H, g = G @ np.linalg.solve(P, G.T), h + G @ np.linalg.solve(P, q)
    n = len(g)
    H[np.diag_indices(n)] *= 1 + 1e-13
    z, factor, index = np.zeros((n, 1)), np.zeros((n, n + 7)), np.zeros((n, 1), dtype=np.int32)
    rank = library.mju_boxQP(z, factor, index, H, g[:, None], np.zeros((n, 1)), None)
    return Called(_impulses(given, z.ravel()), rank >= 0)


def quantecon(given: Arrays, tol: float) -> Called:
    lemke: Any = import_module("quantecon.optimize.lcp_lemke").lcp_lemke
    M, q = _lcp(given)
    found = lemke(M, q)
    return Called(_of_lcp(found.z), found.success)


def drake(given: Arrays, tol: float) -> Called:
    library: Any = import_module("pydrake.solvers")
    M, q = _lcp(given)
    program = library.MathematicalProgram()
    z = program.NewContinuousVariables(len(q))
    program.AddLinearComplementarityConstraint(M, q, z)
    found = library.UnrevisedLemkeSolver().Solve(program, None, None)
    return Called(_of_lcp(found.GetSolution(z)), found.is_success())


def pinocchio(given: Arrays, tol: float) -> Called:
    pin: Any = import_module("pinocchio")
    nc = len(given.mu)
    own = np.column_stack([3 * np.arange(nc) + 2, 3 * np.arange(nc)]).ravel()
    W, g = np.zeros((3 * nc, 3 * nc), order="F"), np.zeros(3 * nc)
    W[np.ix_(own, own)], g[own] = _delassus(given)
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


def siconos(given: Arrays, tol: float) -> Called:
    sent = {field: value for field, value in given._asdict().items() if field != "M"} | {"mass": given.M}
    found = child(str(Path(__file__).with_name("direct_siconos.py")), PYTHON).ask(tol=tol, **sent)
    return Called(found["r"].reshape(-1, 2), not found["code"], found["clock"])


def path(given: Arrays, tol: float) -> Called:
    gp: Any = import_module("gamspy")
    M, q = _lcp(given)
    model, parameters, z = _gams_model(len(q))
    for symbol, values in zip(parameters, (M, q), strict=True):
        symbol.setRecords(values)
    z.setRecords(np.zeros(len(q)))
    log = io.StringIO()
    options = {"convergence_tolerance": tol / 10}
    model.solve(solver="path", solver_options=options, output=log, options=gp.Options(solve_link_type="memory"))
    clock = re.search(r"Total Time[. ]*([\d.]+)", log.getvalue())
    claimed = model.status.name in ("OptimalGlobal", "OptimalLocal")
    return Called(_of_lcp(z.records["level"].to_numpy()), claimed, float(clock[1]) if clock else None)


# The variant of an adapter, and the call by hand that makes the same choices.
CALLS: dict[str, Callable[[Arrays, float], Called]] = {
    "clarabel[keep=false]": clarabel,
    "osqp[keep=false]": osqp,
    "proxsuite[matrices=sparse]": proxsuite,
    "piqp": piqp,
    "daqp": daqp,
    "quadprog": quadprog,
    "mujoco_boxqp[settings=default]": mujoco_boxqp,
    "quantecon[settings=default]": quantecon,
    "drake[method=unrevised]": drake,
    "pinocchio[method=admm]": pinocchio,
    "mujoco[method=newton]": mujoco,
    "siconos[method=friction_2d_nsgs]": siconos,
    "path": path,
}


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


def _qp(given: Arrays) -> tuple[Array, Array, Array, Array]:
    """P, q, G and h with G v <= h."""
    M, N, T, v, b, mu = given
    slip = mu[:, None] * T
    return M, -M @ v, -np.stack([N + slip, N - slip], axis=1).reshape(2 * len(mu), len(v)), np.repeat(b, 2)


def _impulses(given: Arrays, z: Array) -> Array:
    """The impulses of the QP's multipliers."""
    return np.column_stack([z[0::2] + z[1::2], given.mu * (z[0::2] - z[1::2])])


def _delassus(given: Arrays) -> tuple[Array, Array]:
    """W and q, a contact's normal row first."""
    M, N, T, v, b, mu = given
    J = np.stack([N, T], axis=1).reshape(2 * len(mu), len(v))
    q = J @ v
    q[0::2] += b
    return J @ np.linalg.solve(M, J.T), q


def _lcp(given: Arrays) -> tuple[Array, Array]:
    """The friction LCP's M and q."""
    W, q = _delassus(given)
    nc = len(given.mu)
    D = np.zeros((2 * nc, 3 * nc))
    i = np.arange(nc)
    D[2 * i, i], D[2 * i + 1, nc + i], D[2 * i + 1, 2 * nc + i] = 1.0, 1.0, -1.0
    M = np.zeros((4 * nc, 4 * nc))
    M[: 3 * nc, : 3 * nc] = D.T @ W @ D
    M[nc + i, 3 * nc + i] = M[2 * nc + i, 3 * nc + i] = 1.0
    M[3 * nc + i, i], M[3 * nc + i, nc + i], M[3 * nc + i, 2 * nc + i] = given.mu, -1.0, -1.0
    return M, np.concatenate([D.T @ q, np.zeros(nc)])


def _of_lcp(z: Array) -> Array:
    """The impulses of the friction LCP's solution."""
    nc = len(z) // 4
    return np.column_stack([z[:nc], z[nc : 2 * nc] - z[2 * nc : 3 * nc]])
