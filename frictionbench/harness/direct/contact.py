"""Calls by hand of solvers of contact problems, on the Delassus matrix or the contact rows."""

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from frictionbench.harness.direct.given import Arrays, Called, delassus
from frictionbench.solvers.outside.children.child import child
from frictionbench.solvers.outside.siconos import PYTHON


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
    sent = {field: value for field, value in given._asdict().items() if field != "M"} | {"mass": given.M}
    found = child(str(Path(__file__).with_name("siconos_child.py")), PYTHON).ask(tol=tol, **sent)
    return Called(found["r"].reshape(-1, 2), not found["code"], found["clock"])
