"""The convex relaxation of a friction problem (Anitescu 2006; Anitescu and Tasora 2010).

Coulomb's law without de Saxcé's shift requires that -u is in the normal cone of K at r. This is the optimality condition of

    min  ½ v'Mv - (M v*)'v + b_f'y    subject to    u = J v + offset,   F v + b_F = 0,
         u_n >= mu |u_t|  at every contact,    y_i >= |u_t,i|  at contacts with b_f,i > 0.

The multipliers are the impulses. A sliding contact separates at u_n = mu |u_t|, which is the error of the model.
In the plane and with a polygonal section the constraints are linear. Each contact with a friction bias has a slack y, because
its set K is wider than a cone by b_f.

In both programs every contact has m rows (e_k u_n + mu d_k.u_t), and a contact with a friction bias has m further rows
(e_k y + d_k.u_t). For a polygon, e_k = 1 and the d_k are its corners. For a circular cone, row 0 has e = 1 and d = 0, and each
other row is one component of u_t. One kernel therefore assembles the matrices of both programs, by columns.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from frictionbench.problems.compiled import kernel
from frictionbench.problems.forms.delassus import largest
from frictionbench.problems.mechanics import Mechanics
from frictionbench.problems.rows import Array, Rows

LEAST_BIAS = 1e-12  # relative to a contact's unit: friction biases that change its velocity by less are left out of a program
EDGES = np.array([[1.0, 1.0], [1.0, -1.0]])  # the section in the plane


@dataclass(frozen=True, eq=False)
class Program:
    """min ½ x'Px + q'x,   x = (v, y),   with A x = b and h - G x >= 0 or, for a round cone, in second-order cones.

    objective and bounds are P and G by columns (start, row, value), with ascending rows; joints is A by rows.
    section: (m, d), the rows (e_k, d_k). impulse(z) turns the multipliers z of G into the contact impulses (nc, d).
    """

    objective: Rows
    q: Array
    bounds: Rows
    h: Array
    joints: Rows
    b: Array
    section: Array
    friction: Array
    friction_bias: Array

    @cached_property
    def P(self) -> sparse.csc_array:
        return _by_columns(self.objective, len(self.q))

    @cached_property
    def G(self) -> sparse.csc_array:
        return _by_columns(self.bounds, len(self.h))

    @cached_property
    def A(self) -> sparse.csc_array:
        return sparse.csc_array(self.joints.matrix(len(self.q)))

    def impulse(self, z: Array) -> Array:
        return multiplied(self.section, self.friction, self.friction_bias, z)


def relaxation(problem: Mechanics, section: Array) -> Program:
    """The relaxation with this section of the cone, as a program in x = (v, y)."""
    mu, b_f, M = problem.friction, bias_of_size(problem), problem.mass_rows
    p_start, q, *G, h = matrices(*problem.contact_rows, *M, problem.free_velocity, problem.offset, mu, b_f, section)
    P = Rows(p_start, M.column, M.value)
    return Program(P, q, Rows(*G), h, problem.joint_rows, -problem.joint_bias, section, mu, b_f)


def bias_of_size(problem: Mechanics) -> Array:
    """b_f, 0 where it is of rounding's size: its slack would cost nothing, and grow without bound."""
    b_f = problem.friction_bias
    return np.where(b_f * problem.scale > LEAST_BIAS * problem.units, b_f, 0.0) if largest(b_f, 1) else b_f


def _by_columns(columns: Rows, rows: int) -> sparse.csc_array:
    return sparse.csc_array((columns.value, columns.column, columns.start), shape=(rows, len(columns.start) - 1))


@kernel
def matrices(start, column, J, m_start, m_column, m_value, free, offset, mu, b_f, section):  # type: ignore[no-untyped-def]
    """The starts of P's columns, q, G by columns (start, row, value) without zeros, and h. offset: (nc, d), or (nc, 1) if the
    others are 0."""
    nc, nv, m, d = len(mu), len(free), len(section), J.shape[1]
    wide = 0
    for i in range(nc):
        wide += b_f[i] > 0
    P_start, q, h = np.empty(nv + wide + 1, np.int32), np.zeros(nv + wide), np.zeros((nc + wide) * m)
    for v in range(nv):
        P_start[v] = m_start[v]
        for k in range(m_start[v], m_start[v + 1]):
            q[v] -= m_value[k] * free[m_column[k]]
    for v in range(nv, nv + wide + 1):
        P_start[v] = m_start[nv]
    most = 2 * m * len(column) + m * wide
    G_start, row, value = np.zeros(nv + wide + 2, np.int32), np.empty(most, np.int32), np.empty(most)
    for fill in (False, True):  # count the entries of column v in G_start[v + 2], then fill from position G_start[v + 1]
        block = 0
        for segment in (False, True):
            for i in range(nc):
                if segment and not b_f[i] > 0:
                    continue
                for k in range(m):
                    along = 0.0 if segment else section[k, 0]
                    across = 1.0 if segment else mu[i]
                    at = block * m + k
                    for e in range(start[i], start[i + 1]):
                        entry = along * J[e, 0]
                        for a in range(1, d):
                            entry += across * section[k, a] * J[e, a]
                        if entry != 0:
                            if fill:
                                row[G_start[column[e] + 1]], value[G_start[column[e] + 1]] = at, -entry
                            G_start[column[e] + (1 if fill else 2)] += 1
                    if segment and section[k, 0] != 0:
                        slack = nv + block - nc
                        if fill:
                            row[G_start[slack + 1]], value[G_start[slack + 1]] = at, -section[k, 0]
                        G_start[slack + (1 if fill else 2)] += 1
                    if fill:
                        h[at] = along * offset[i, 0]
                        for a in range(1, offset.shape[1]):
                            h[at] += across * section[k, a] * offset[i, a]
                if segment and fill:
                    q[nv + block - nc] = b_f[i]
                block += 1
        if not fill:
            for v in range(nv + wide):
                G_start[v + 2] += G_start[v + 1]
    return P_start, q, G_start[: nv + wide + 1], row[: G_start[nv + wide]], value[: G_start[nv + wide]], h


@kernel
def multiplied(section, mu, b_f, z):  # type: ignore[no-untyped-def]
    """The contact impulses (nc, d): the coefficients of the rows times their multipliers z."""
    nc, (m, d) = len(mu), section.shape
    r, block = np.zeros((nc, d)), nc
    for i in range(nc):
        for k in range(m):
            r[i, 0] += section[k, 0] * z[i * m + k]
            for a in range(1, d):
                r[i, a] += mu[i] * section[k, a] * z[i * m + k]
        if b_f[i] > 0:
            for k in range(m):
                for a in range(1, d):
                    r[i, a] += section[k, a] * z[block * m + k]
            block += 1
    return r
