"""MuJoCo in a process of its own, for solvers.outside.mujoco: a friction problem in place of the constraint rows of a template.

The template has nv bodies of unit mass on slides and nc touching spheres, so that the mass matrix is the identity and its rows
are those of nc contacts; then J, R, the reference and the friction are overwritten. (A call of mj_projectConstraint afterwards
would crash; with island discovery on, the answer would be wrong.)
"""

from functools import cache
from time import perf_counter
from typing import Any

import mujoco
import numpy as np
from messages import Array, serve  # this folder is on the path of the child

_FIXED = 'gravity="0 0 0" cone="elliptic" impratio="1" jacobian="dense" ls_iterations="100" tolerance="0"'


@cache
def template(nv: int, nc: int, solver: str, iterations: int) -> tuple[Any, Any]:
    """MuJoCo's model and data for so many velocities and contacts."""
    spheres = "".join(f'<geom type="sphere" size=".1" pos="{j} 0 .0999" contype="1" conaffinity="0"/>' for j in range(nc))
    inertia = '<joint type="slide" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    bodies = "".join(f"<body>{inertia}{'' if i else spheres}</body>" for i in range(nv))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option {_FIXED} solver="{solver}" iterations="{iterations}">'
        f'<flag warmstart="disable" island="disable"/></option>'
        f'<default><geom condim="3"/></default><worldbody>'
        f'<geom type="plane" size="9999 9999 .1" contype="0" conaffinity="1"/>{bodies}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def answer(**message: Any) -> dict[str, Any]:
    """Solve the problem of the message: a box-constrained QP, or soft contacts."""
    return box(**message) if "H" in message else soft(**message)


def box(H: Array, g: Array) -> dict[str, Any]:
    """min ½z'Hz + g'z, z >= 0: z, the rank that mju_boxQP returns (-1 for a failure), seconds."""
    n = len(g)
    z, factor, index = np.zeros((n, 1)), np.zeros((n, n + 7)), np.zeros((n, 1), dtype=np.int32)
    H, g, lower = np.ascontiguousarray(H), g[:, None], np.zeros((n, 1))
    begun = perf_counter()
    rank = mujoco.mju_boxQP(z, factor, index, H, g, lower, None)
    return {"z": z.ravel(), "rank": int(rank), "clock": perf_counter() - begun}


def soft(solver: str, iterations: int, R: float, J: Array, v: Array, b: Array, mu: Array) -> dict[str, Any]:
    """min ½|x - v|² + the soft cones of J x + b, rows (n, t1, t2) a contact: forces, last gradient, iterations, seconds."""
    model, data = template(J.shape[1], len(mu), solver, iterations)
    if data.nefc != len(J):
        return {"f": np.zeros(len(J)), "gradient": float("inf"), "iterations": 0, "clock": 0.0}
    data.efc_J[:] = J.ravel()
    data.efc_margin[:] = data.efc_pos[:] = 0
    data.efc_aref[:] = -b
    data.efc_R[:], data.efc_D[:] = R, 1 / R
    mu = np.maximum(mu, 1e-8)  # its elliptic cone needs friction
    data.contact.mu[:] = mu
    data.contact.friction[:, :2] = mu[:, None]
    data.qacc_smooth[:] = data.qfrc_smooth[:] = v
    begun = perf_counter()
    mujoco.mj_fwdConstraint(model, data)
    seconds = perf_counter() - begun
    f = data.efc_force.copy()
    gradient = float(np.abs(data.qacc - v - J.T @ f).max())
    return {"f": f, "gradient": gradient, "iterations": int(data.solver_niter[0]), "clock": seconds}


serve(answer)
