"""The dimensionless form of a friction problem with mass matrix and Jacobian apart, as Siconos' global drivers take it.

With v = theta D v^, D = 1/sqrt(M_ii), and r = theta E r^ (solvers.outside.scaled_delassus), M (v - v*) = J'r and u = J v + b
become

    M^ v^ = H^ r^ + q^,    u^ = H^'v^ + b^,      M^ = D M D,    H^ = D J'E,    q^ = D M v* / theta,    b^ = E b / theta.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus


def global_form(problem: FrictionProblem, given: ScaledDelassus) -> dict[str, Array]:
    """M^ and H^ by entries (row, column, value), q^ (nv,) and b^ (nc*d,) of a problem without joints."""
    M, H, q, b = _entries(
        *problem.contact_rows, *problem.mass_rows, problem.free_velocity, problem.offset, given.E, given.theta
    )
    return {"M": M, "H": H, "q": q, "b": b}


@kernel
def _entries(start, column, J, m_start, m_column, m_value, free, offset, E, theta):  # type: ignore[no-untyped-def]
    """M^ = D M D and H^ = D J'E by entries, q^ = D M v* / theta and b^ = E b / theta."""
    nc, nv, d = len(E), len(free), J.shape[1]
    D, q, b = np.empty(nv), np.zeros(nv), np.empty(nc * d)
    M, H, at = np.empty((len(m_value), 3)), np.empty((J.size, 3)), 0
    for v in range(nv):
        for k in range(m_start[v], m_start[v + 1]):
            if m_column[k] == v:
                D[v] = 1 / np.sqrt(m_value[k])
    for v in range(nv):
        for k in range(m_start[v], m_start[v + 1]):
            M[k, 0], M[k, 1], M[k, 2] = v, m_column[k], D[v] * m_value[k] * D[m_column[k]]
            q[v] += D[v] * m_value[k] * free[m_column[k]] / theta
    for i in range(nc):
        for a in range(d):
            b[i * d + a] = E[i] * offset[i, a] / theta
            for k in range(start[i], start[i + 1]):
                if J[k, a] != 0:
                    H[at, 0], H[at, 1], H[at, 2] = column[k], i * d + a, D[column[k]] * J[k, a] * E[i]
                    at += 1
    return M, H[:at], q, b
