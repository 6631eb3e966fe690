"""MuJoCo's constraint solvers on a given friction problem.

The contacts are soft: Newton and CG minimise the relaxation with u = W r + q + R r, and R determines the distance
from hard contacts, so that a ladder of tolerances is a sweep of R. Cones are elliptic, with R = max(tol, 1e-7) s at every
contact. In the plane Newton's are pyramidal if no mu is between 0 and 0.1: two frictionless rows u_n +- mu u_t a contact, with
multipliers z >= 0, r_n = z_1 + z_2 and r_t = mu (z_1 - z_2). An R_z on both rows is an R of R_z / 2 along n and R_z / (2 mu^2)
along t, here with R_z = 2 max(tol, 1e-6) min(1, mu^2) s (without friction mu = 1), so that R <= max(tol, 1e-6) s. With smaller
R or mu Newton stalls on some problems, as rounding errors of velocities are divided by R_z.

They take no matrices. A template of MuJoCo's own has nv slides with an armature of 1 and touching spheres, one a contact or a
row; the mass matrix, J, R, the reference and the friction are then overwritten. J is sparse, faster than dense from some 16
velocities on and 10 µs slower with three; as many slides as a row has entries move all spheres, for MuJoCo makes room for no
more. (A call of mj_projectConstraint afterwards would crash; with island discovery on, the answer would be wrong.)

Its contact rows are J^, or n +- mu t of them, on velocities of unit mass: with M = L L', w = L'v / theta and r = theta E r^
(solvers.outside.scaled_delassus),

    J^ = E J L^-T,      w* = L'v* / theta,      b^ = E b / theta,      W^ = J^ J^',      q^ = J^ w* + b^.

Licence: Apache-2.0.
Form: dimensionless contact rows, two or three a contact, on velocities of unit mass, compressed. Setup: MuJoCo's template, once
    per size. Solve: the transfer of the rows into it, and mj_fwdConstraint.
Clock: around mj_fwdConstraint.
Charged: in space some 8 µs more than a call by hand at 2 contacts: the dimensionless form.
Settings: island discovery and warm start off, as above, and the cones. The line search's defaults are ls_tolerance = 0.01 and
    ls_iterations = 50; tuned are 1e-8 and 100.
Tolerance: R as above, and MuJoCo's tolerance 0, with pyramids 1e-30: it iterates until it makes no progress, and its gradient
    decides the status. (With 0 a line search that has found its minimum exactly does not end before its limit.) Newton is given
    1000 iterations and CG 2000; MuJoCo's own limit is 100.
Flaws: CG is far from the minimum of its soft contacts after 2000 iterations, `frictionbench solve
    'stack[blocks=5,friction=0.2,push=1]' --solver 'mujoco[method=cg]'`.
Reference: Todorov 2014, "Convex and analytically-invertible dynamics with contacts and constraints".
"""

from functools import lru_cache
from importlib import import_module
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside import untimed
from frictionbench.solvers.outside.scaled_delassus import SPACE, ScaledDelassus, scaled_delassus

_ITERATIONS = {"newton": 1000, "cg": 2000}  # by default
_CONES, _PYRAMIDS = (1e-7, 0.0), (1e-6, 1e-30)  # the least value of max(tol, ...), and MuJoCo's tolerance
_LEAST_FRICTION = 0.1  # of pyramids, but for none
_SEARCH = {"default": (0.01, 50), "tuned": (1e-8, 100)}  # ls_tolerance and ls_iterations

# The scaling; rows J^ (m nc, nv), m = 3 a contact, normal first, or a pyramid's 2; w* (nv,) and b^ (m nc,); R of the rows, as a
# multiple of the larger of tol and its least value (m nc,); J^ compressed.
Whitened = tuple[ScaledDelassus, Array, Array, Array, Array, tuple[NDArray[Any], ...]]
# These, MuJoCo's model and data, and its arrays that are overwritten: a look at one makes an object, which takes its time.
Prepared = tuple[Whitened, tuple[Any, ...]]


@solver(
    "mujoco",
    family="outside",
    model="regularised",
    dimension=(2, 3),
    needs=("mujoco",),
    lacks=("friction_bias", "joints", "asymmetry"),
    variants=("method=newton", "method=newton,settings=tuned", "method=cg", "method=cg,settings=tuned"),
)
class MuJoCo:
    """MuJoCo's Newton or CG on soft contacts. (outside)

    method: newton or cg. settings: default or tuned. Work: iterations.
    """

    method: str = "newton"
    settings: str = "default"

    def form(self, problem: FrictionProblem) -> Whitened:
        """Of a problem without joints; the third row of a planar contact with an elliptic cone is zero."""
        firm = all(mu == 0 or mu >= _LEAST_FRICTION for mu in problem.friction.tolist())
        pyramids = firm and problem.dimension == 2 and self.method == "newton"
        scaled = scaled_delassus(problem, None if pyramids else SPACE, matrix=False, relaxed=True)
        motion, law = (problem.free_velocity, problem.offset), (scaled.friction, len(scaled.rows))
        return scaled, *_whiten(*problem.contact_rows, *problem.mass_rows, *motion, *law, scaled.E, scaled.theta)

    def setup(self, form: Whitened) -> Prepared:
        scaled, _, v, b, _, (counts, *_) = form
        spheres = (len(b), 1) if len(scaled.rows) == 2 else (len(scaled.friction), 3)
        return form, _template(len(v), *spheres, max(1, *counts.tolist()))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        mujoco: Any = import_module("mujoco")
        (scaled, J, v, b, R, (counts, begins, columns, values)), (model, data, arrays) = prepared
        options, pyramids = model.opt, len(scaled.rows) == 2
        options.solver = mujoco.mjtSolver.mjSOL_NEWTON if self.method == "newton" else mujoco.mjtSolver.mjSOL_CG
        options.iterations = limit or _ITERATIONS[self.method]
        options.ls_tolerance, options.ls_iterations = _SEARCH[self.settings]
        least, options.tolerance = _PYRAMIDS if pyramids else _CONES
        mu = scaled.friction.repeat(2) if pyramids else np.maximum(scaled.friction, 1e-8)  # its elliptic cone needs friction
        R = max(tol, least) * R
        for array, value in zip(arrays, (counts, begins, 0, -b, R, 1 / R, 0, 0, mu, mu[:, None], v, v), strict=True):
            array[:] = value
        data.efc_J_colind[: len(values)], data.efc_J[: len(values)] = columns, values
        begun = perf_counter()
        mujoco.mj_fwdConstraint(model, data)
        clock = perf_counter() - begun
        f = data.efc_force.copy()
        gradient = float(np.abs(data.qacc - v - J.T @ f).max())
        status = Status.SOLVED if gradient <= scaled.share * tol else Status.STALLED
        r, softness = _of_contacts(f, R, scaled.friction, scaled.scale, scaled.contacts[1])
        answer = scaled.answer(r, status, f"gradient {gradient:.1e}", clock, iterations=int(data.solver_niter[0]))
        answer.softness = softness
        return answer


@lru_cache(maxsize=8)  # some 50 MB each
@untimed()
def _template(nv: int, nc: int, directions: int, moving: int) -> tuple[Any, ...]:
    """MuJoCo's for so many velocities, of which the last `moving` move the spheres, and contacts of 1 or 3 directions; then
    arrays of data: of the rows, of the contacts, of the velocities."""
    mujoco: Any = import_module("mujoco")
    spheres = "".join(f'<geom type="sphere" size=".1" pos="{j} 0 .0999" contype="1" conaffinity="0"/>' for j in range(nc))
    body = '<body><joint type="slide" axis="0 0 1" armature="1"/><inertial pos="0 0 0" mass="1e-12" diaginertia="1 1 1"/>'
    bodies = f"{body}</body>" * (nv - moving) + body * moving + spheres + "</body>" * moving
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option gravity="0 0 0" cone="elliptic" impratio="1" jacobian="sparse">'
        '<flag warmstart="disable" island="disable"/></option>'
        f'<default><geom condim="{directions}" mass="0"/></default><worldbody>'
        f'<geom type="plane" size="9999 9999 .1" contype="0" conaffinity="1"/>{bodies}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    data.M[:] = 0
    data.M[model.M_rowadr + model.M_rownnz - 1] = 1
    mujoco.mj_factorM(model, data)
    names = "J_rownnz", "J_rowadr", "J_rowsuper", "aref", "R", "D", "margin", "pos"
    rows = (getattr(data, f"efc_{name}") for name in names)
    return model, data, (*rows, data.contact.mu, data.contact.friction[:, :2], data.qacc_smooth, data.qfrc_smooth)


@kernel
def _whiten(start, column, J, m_start, m_column, m_value, free, offset, mu, m, E, theta):  # type: ignore[no-untyped-def]
    """J^, w*, b^, the rows' R and J^ compressed, with m rows a contact."""
    nc, nv, d = len(E), len(free), J.shape[1]
    L, begin = _factor(m_start, m_column, m_value)
    rows, v, b, R = np.zeros((m * nc, nv)), np.zeros(nv), np.zeros(m * nc), np.ones(m * nc)
    for j in range(nv):
        for k in range(begin[j], j + 1):
            v[k] += L[j, k] * free[j] / theta
    for i in range(nc):
        for a in range(d):
            row, side = rows[m * i + a], -mu[i] if a else mu[i]
            R[m * i + a] = 1.0 if m == 3 else 2 * min(1.0, mu[i] ** 2 if mu[i] > 0 else 1.0)
            for k in range(start[i], start[i + 1]):
                row[column[k]] = E[i] * (J[k, a] if m == 3 else J[k, 0] + side * J[k, 1])
            b[m * i + a] = E[i] * (offset[i, a] if m == 3 else offset[i, 0] + side * offset[i, 1]) / theta
            for j in range(nv):  # L y = (E J)'
                for k in range(begin[j], j):
                    row[j] -= L[j, k] * row[k]
                row[j] /= L[j, j]
    return rows, v, b, R, _compressed(rows, m)


@part
def _compressed(rows, m):  # type: ignore[no-untyped-def]
    """The number of each row's entries, alike in a contact's m, and where they begin; their columns and values."""
    counts, begins, at = np.zeros(len(rows), np.int32), np.zeros(len(rows), np.int32), 0
    columns, values = np.empty(rows.size, np.int32), np.empty(rows.size)
    for i in range(len(rows)):
        begins[i], first = at, i - i % m
        for j in range(rows.shape[1]):
            if rows[first, j] != 0 or rows[first + 1, j] != 0 or rows[first + m - 1, j] != 0:
                columns[at], values[at] = j, rows[i, j]
                at += 1
        counts[i] = at - begins[i]
    return counts, begins, columns[:at], values[:at]


@part
def _factor(start, column, value):  # type: ignore[no-untyped-def]
    """L (nv, nv) and the column of the first entry of each of its rows, as in M: of blocks, the blocks are factorised."""
    n = len(start) - 1
    L, begin = np.zeros((n, n)), np.empty(n, np.int64)
    for i in range(n):
        begin[i] = min(column[start[i]], i)
        for k in range(start[i], start[i + 1]):
            if column[k] <= i:
                L[i, column[k]] = value[k]
        for j in range(begin[i], i + 1):
            for k in range(max(begin[i], begin[j]), j):
                L[i, j] -= L[i, k] * L[j, k]
            L[i, j] = np.sqrt(L[i, i]) if i == j else L[i, j] / L[j, j]
    return L, begin


@kernel
def _of_contacts(f, R, mu, scale, d):  # type: ignore[no-untyped-def]
    """r^, of a pyramid (r_n, r_t), and the softness (nc, d) of contacts with the forces f and R of their rows."""
    r, softness, m = f.copy(), np.empty((len(mu), d)), len(f) // max(1, len(mu))
    for i in range(len(mu)):
        softness[i] = R[m * i] * scale[i]
        if m == 2:
            r[2 * i], r[2 * i + 1] = f[2 * i] + f[2 * i + 1], mu[i] * (f[2 * i] - f[2 * i + 1])
            softness[i, 0], softness[i, 1] = softness[i, 0] / 2, softness[i, 1] / (2 * mu[i] ** 2 if mu[i] > 0 else 2.0)
    return r, softness
