"""The dimensionless convex relaxation, in which the tolerances of all outside libraries have the same meaning.

The program  min ½ x'Px + q'x,  h - G x in a cone,  A x = b  of problems.forms.relaxation becomes, with x = x* + theta D x^,

    P^ = D P D,    q^ = D (q + P x*) / theta,    G^ = E G D,    h^ = E (h - G x*) / theta,
    A^ = E_A A D,    b^ = E_A (b - A x*) / theta,

x* = (v*, |u*_t|) the free motion, so that q^ is 0 on velocities and the objective is the energy of the change of velocity: no
library's test subtracts objectives in which a motion that the contacts leave alone is the larger part. D = 1/sqrt(M_ii) on
velocities and E_i = 1/sqrt(s_i) on contact i's rows: a unit diagonal in the objective, rows of about unit length, and
theta = max_i min(|q_i|, unit_i) / sqrt(s_i), unit_i that of problems.residual, makes h^, the free contact velocities, at most
about 1 but where a contact is open by far. Then z = theta E z^. Rows are u_n + mu_i d.u_t, so an error eps in a scaled row is
eps theta sqrt(s_i) of normal and 1/mu_i times that of tangential velocity, and

    eps = tol min_i min(1, mu_i) unit_i / (theta sqrt(s_i))  <=  tol

keeps every contact's velocity error below tol unit_i, the measure of problems.residual. (Below mu_i = 0.01 it is 0.01 that
counts, the tangential impulse being next to nothing, and without friction 1.)

The duality gap is the sum of the products r_i'u_i. Where impulse and velocity vanish together (a contact about to slide or to
part), and all along a round cone, a gap of eps leaves an error of sqrt(eps): so the requested gap is eps^2, but not less than
the difference of two objectives of size 1 that a library reaches in floating point; each adapter states that number.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.islands import length
from frictionbench.problems.forms.relaxation import EDGES, bias_of_size, matrices, multiplied
from frictionbench.problems.rows import Index32
from frictionbench.solvers.interface import Answer, Status, impulses, solver
from frictionbench.solvers.outside.scaled_delassus import size_and_share

LEAST_FRICTION = 0.01
relaxation_library = partial(solver, family="relaxation", model="relaxation", lacks=("asymmetry",))  # registers an adapter

Columns = tuple[Index32, Index32, Array]  # a matrix by columns: start, row and value; or by rows
_SECTIONS = {2: EDGES, 3: np.eye(3)}


@dataclass(eq=False)
class ScaledProgram:
    """The scaled program: objective and bounds are P and G by columns, joints is A by rows.

    unit: of the multipliers of G. share: eps over tol. law: the section, mu and b_f of problems.forms.relaxation.
    """

    law: tuple[Array, Array, Array]
    objective: Columns
    q: Array
    bounds: Columns
    h: Array
    joints: Columns
    b: Array
    unit: Array
    share: float

    @property
    def contacts(self) -> tuple[int, int]:
        return len(self.law[1]), self.law[0].shape[1]

    def matrices(self, dense: bool, upper: bool = False) -> tuple[Any, Any, Any, Array | None]:
        """P, or its upper half, G, A and b, dense in C order or sparse by columns; A and b are None without joints."""
        matrix = _dense if dense else _matrix
        P = matrix(len(self.q), *(_upper(*self.objective) if upper else self.objective))
        G = matrix(len(self.h), *self.bounds)
        if not len(self.b):
            return P, G, None, None
        A = matrix(len(self.q), *self.joints).T
        return P, G, A.copy() if dense else A.tocsc(), self.b

    def limits(self, least: float) -> tuple[Array, Array]:
        """Of the rows of G above A, from below and above; `least` for those of G, which have none from below."""
        upper = np.concatenate([self.h, self.b]) if len(self.b) else self.h
        lower = np.full(len(upper), least)
        lower[len(self.h) :] = self.b
        return lower, upper

    def multipliers(self, impulse: Array) -> Array:
        """Scaled multipliers of G that make about these planar impulses, for a warm start; the friction bias is ignored."""
        impulse, mu = impulses(impulse, self.contacts), self.law[1]
        n, slip = impulse[:, 0], impulse[:, 1] / np.where(mu > 0, mu, 1.0)
        z = np.zeros(len(self.h))
        z[: 2 * len(n)] = np.maximum(np.column_stack([n + slip, n - slip]).ravel() / 2, 0.0)
        return z / self.unit

    def tolerances(self, tol: float, least: float) -> tuple[float, float]:
        """eps, and the duality gap at which errors are below it, or the least that the library reaches."""
        eps = tol * self.share
        return eps, max(eps**2, least)

    def answer(
        self, z: Array | None, solved: bool, iterations: int | None = None, detail: str = "", clock: float | None = None
    ) -> Answer:
        """The answer of scaled multipliers, of which the first belong to G; None where the library returned nothing."""
        nothing = z is None or not len(z)
        impulse = np.zeros(self.contacts) if nothing else multiplied(*self.law, self.unit * z[: len(self.h)])  # type: ignore[index]
        work = {} if iterations is None else {"iterations": iterations}
        return Answer(impulse, Status.SOLVED if solved else Status.FAILED, work, detail=detail, clock=clock)


def stacked(*matrices: Any) -> Any:
    """One above the other, without those that are None."""
    first, *others = (matrix for matrix in matrices if matrix is not None)
    together = np.vstack if isinstance(first, np.ndarray) else partial(sparse.vstack, format="csc")
    return together([first, *others]) if others else first


def scaled_program(problem: FrictionProblem, from_free: bool = False) -> ScaledProgram:
    """Scale a problem's relaxation, the QP in the plane and the cone program in space.

    from_free: x* as above, for libraries that stop by a duality gap; otherwise x* = 0. First-order methods start from x^ = 0
    and regularised ones are drawn to it, and rest is nearer to most answers than free motion.
    """
    units = problem.relaxation_units  # with them, the scale and q are computed, which are the same for both laws
    law = _SECTIONS[problem.dimension], problem.friction, bias_of_size(problem)
    rows = *problem.contact_rows, *problem.mass_rows, *problem.joint_rows
    motion = problem.free_velocity, problem.offset, problem.joint_bias
    fields: tuple[Any, ...] = _scaled(*rows, *motion, *law, problem.scale, problem.q, units, from_free)
    return ScaledProgram(law, *fields)


def _matrix(rows: int, start: Index32, row: Index32, value: Array) -> sparse.csc_matrix:
    return sparse.csc_matrix((value, row, start), shape=(rows, len(start) - 1))


@kernel
def _scaled(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, f_start, f_column, f_value, free, offset, f_bias, section, mu, b_f,
    scale, contact_velocity, units, from_free,
):  # fmt: skip
    """The fields of ScaledProgram but for the law."""
    p_start, q, g_start, g_row, g_value, h = matrices(
        start, column, J, m_start, m_column, m_value, free, offset, mu, b_f, section
    )
    nv, d, at, x = len(free), offset.shape[1], len(free), np.zeros(len(q))
    if from_free:
        q[:nv], x[:nv] = 0.0, free
        for i in range(len(mu)):
            if b_f[i] > 0:
                x[at] = length(contact_velocity[i * d + 1 : i * d + d], 0, d - 1)
                at += 1
        for v in range(len(x)):
            for k in range(g_start[v], g_start[v + 1]):
                h[g_row[k]] -= g_value[k] * x[v]
    weight = 1 / np.where(mu > 0, np.minimum(1.0, np.maximum(LEAST_FRICTION, mu)), 1.0)
    theta, share = size_and_share(scale, contact_velocity, units, weight)
    wide = scale[b_f > 0]  # of the contacts that have a second block of rows, and a variable
    root = np.sqrt(np.append(scale, wide))  # 1/E
    m, D, P = len(section), np.ones(len(q)), np.empty(len(m_value))
    for v in range(nv):
        for k in range(p_start[v], p_start[v + 1]):
            if m_column[k] == v:
                D[v] = 1 / np.sqrt(m_value[k])
    D[nv:] = root[len(scale) :]
    for j in range(len(q)):
        q[j] = D[j] * q[j] / theta
        for k in range(p_start[j], p_start[j + 1]):
            P[k] = m_value[k] * D[j] * D[m_column[k]]
        for k in range(g_start[j], g_start[j + 1]):
            g_value[k] = g_value[k] * D[j] * (1 / root[g_row[k] // m])
    unit = np.empty(len(h))
    for i in range(len(h)):
        h[i], unit[i] = h[i] / root[i // m] / theta, theta / root[i // m]
    A, b = _joints(f_start, f_column, f_value, f_bias, D, x, theta)
    # a copy, as some libraries require writable arrays and the columns of the mass matrix belong to the problem
    return (p_start, m_column.copy(), P), q, (g_start, g_row, g_value), h, (f_start, f_column, A), b, unit, share


@part
def _joints(start, column, value, bias, D, x, theta):  # type: ignore[no-untyped-def]
    """The values of A^, its rows of unit length, and b^."""
    scaled, b = value * D[column], np.empty(len(bias))
    for j in range(len(bias)):
        left, square = -bias[j], 0.0
        for k in range(start[j], start[j + 1]):
            left -= value[k] * x[column[k]]
            square += scaled[k] ** 2
        unit = 1 / np.sqrt(square) if square > 0 else 1.0
        b[j] = left * unit / theta
        for k in range(start[j], start[j + 1]):
            scaled[k] *= unit
    return scaled, b


@kernel
def _upper(start, row, value):  # type: ignore[no-untyped-def]
    """The upper half of a matrix by columns, by columns."""
    kept, at = np.zeros(len(start), np.int32), 0
    upper_row, upper = np.empty(len(row), np.int32), np.empty(len(row))
    for j in range(len(start) - 1):
        for k in range(start[j], start[j + 1]):
            if row[k] <= j:
                upper_row[at], upper[at] = row[k], value[k]
                at += 1
        kept[j + 1] = at
    return kept, upper_row[:at], upper[:at]


@kernel
def _dense(rows, start, row, value):  # type: ignore[no-untyped-def]
    """A matrix by columns, dense in C order."""
    dense = np.zeros((rows, len(start) - 1))
    for j in range(len(start) - 1):
        for k in range(start[j], start[j + 1]):
            dense[row[k], j] = value[k]
    return dense
