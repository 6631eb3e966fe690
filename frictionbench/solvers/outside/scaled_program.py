"""The dimensionless convex relaxation, in which the tolerances of all outside libraries have the same meaning.

The program  min ½ x'Px + q'x,  h - G x in a cone,  A x = b  of problems.forms.relaxation becomes, with x = x* + theta D x^,

    P^ = D P D,    q^ = D (q + P x*) / theta,    G^ = E G D,    h^ = E (h - G x*) / theta,
    A^ = E_A A D,    b^ = E_A (b - A x*) / theta,

x* = (v*, |u*_t|) the free motion, so that q^ is 0 on velocities and the objective is the energy of the change of velocity: no
library's test subtracts objectives in which a motion that the contacts leave alone is the larger part. In the plane D =
1/sqrt(m) and E = sqrt(m), m the geometric mean of M's diagonal: but for the units of mass and velocity, a library is given the
matrices as they are, which it scales as it does for its users. Rows and columns are `alike` in space, for steps of robots, and
for libraries that need it: D = 1/sqrt(M_ii) on velocities and E_i = 1/sqrt(s_i) on contact i's rows, for a unit diagonal in the
objective and rows of about unit length. With theta = max_i min(|q_i|, unit_i) E_i, unit_i that of problems.residual, h^, the
free contact velocities, is at most about 1 but where a contact is open by far. Then z = theta E z^. Rows are u_n + mu_i d.u_t,
so an error eps in a scaled row is eps theta / E_i of normal and 1/mu_i times that of tangential velocity, and

    eps = tol min_i min(1, mu_i) unit_i E_i / theta  <=  tol

keeps every contact's velocity error below tol unit_i, the measure of problems.residual. (Below mu_i = 0.01 it is 0.01 that
counts, the tangential impulse being next to nothing, and without friction 1.)

The duality gap is the sum of the products r_i'u_i. Where impulse and velocity vanish together (a contact about to slide or to
part), and all along a round cone, a gap of eps leaves an error of sqrt(eps): so the requested gap is eps^2, but not less than
the difference of two objectives of size 1 that a library reaches in floating point; each adapter states that number.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.problems.forms.islands import length
from frictionbench.problems.forms.relaxation import EDGES, bias_of_size, matrices, multiplied
from frictionbench.solvers.interface import Answer, Status, impulses, solver
from frictionbench.solvers.outside.scaled_delassus import size_and_share

LEAST_FRICTION = 0.01
relaxation_library = partial(solver, family="relaxation", model="relaxation", lacks=("asymmetry",))  # registers an adapter

_SECTIONS = {2: EDGES, 3: np.eye(3)}


@dataclass(eq=False)
class ScaledProgram:
    """The scaled program, with matrices that are dense in C order or sparse by columns; A and b are empty without joints.

    right: h above b. unit: of the multipliers of G. share: eps over tol. law: the section, mu and b_f of
    problems.forms.relaxation.
    """

    law: tuple[Array, Array, Array]
    P: Any
    G: Any
    A: Any
    q: Array
    right: Array
    unit: Array
    share: float

    def __post_init__(self) -> None:
        self.contacts = len(self.law[1]), self.law[0].shape[1]
        self.h, self.b = self.right[: len(self.unit)], self.right[len(self.unit) :]

    @property
    def equations(self) -> tuple[Any, Array | None]:
        """A and b, None without joints."""
        return (self.A, self.b) if len(self.b) else (None, None)

    @cached_property
    def diagonal(self) -> bool:
        """Whether P, if it is dense, is diagonal."""
        return np.count_nonzero(self.P) == np.count_nonzero(self.P.diagonal())

    def stacked(self, joints_first: bool = False) -> Any:
        """G above A, or A above G."""
        if not len(self.b):
            return self.G
        above, below = (self.A, self.G) if joints_first else (self.G, self.A)
        if not sparse.issparse(above):
            return np.vstack([above, below])
        parts = [(matrix.indptr, matrix.indices, matrix.data) for matrix in (above, below)]
        return _matrix(len(self.right), *_above(*parts[0], *parts[1], above.shape[0]))

    def least(self, value: float) -> Array:
        """The lower bounds of the rows of G above A; `value` for those of G, which have none."""
        lower = np.full(len(self.right), value)
        lower[len(self.unit) :] = self.b
        return lower

    def multipliers(self, impulse: Array) -> Array:
        """Scaled multipliers of G that make about these planar impulses, for a warm start; the friction bias is ignored."""
        impulse, mu = impulses(impulse, self.contacts), self.law[1]
        n, slip = impulse[:, 0], impulse[:, 1] / np.where(mu > 0, mu, 1.0)
        z = np.zeros(len(self.unit))
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
        impulse = np.zeros(self.contacts) if nothing else multiplied(*self.law, self.unit * z[: len(self.unit)])  # type: ignore[index]
        work = {} if iterations is None else {"iterations": iterations}
        return Answer(impulse, Status.SOLVED if solved else Status.FAILED, work, detail=detail, clock=clock)


def scaled_program(
    problem: FrictionProblem,
    dense: bool = False,
    from_free: bool = False,
    upper: bool = False,
    alike: bool = False,
    exact: bool = False,
) -> ScaledProgram:
    """Scale a problem's relaxation, the QP in the plane and the cone program in space, in which rows and columns are alike.

    from_free: x* as above, for libraries that stop by a duality gap; otherwise x* = 0. First-order methods start from x^ = 0
    and regularised ones are drawn to it, and rest is nearer to most answers than free motion. upper: of P, if it is sparse.
    exact: in the plane, for active sets, whose answer no tolerance changes: theta is 1, and the share, which is 0, unused.
    """
    if exact:
        scale = units = np.zeros(problem.contacts)
        q = np.zeros(2 * problem.contacts)
    else:  # units first: with them, the scale and q are computed, which are the same for both laws
        units, scale, q = problem.relaxation_units, problem.scale, problem.q
    law = _SECTIONS[problem.dimension], problem.friction, bias_of_size(problem)
    offset = problem.bias[:, None] if problem.mechanical else problem.offset
    motion = problem.free_velocity, offset, problem.joint_bias
    rows, alike = (*problem.contact_rows, *problem.mass_rows, *problem.joint_rows), alike or problem.dimension == 3
    given = *rows, *motion, *law, scale, q, units, from_free, alike
    if dense:
        return ScaledProgram(law, *_dense(*given))
    P, G, A, q, right, unit, share = _program(*given, upper)
    P, G = _matrix(len(q), *P), _matrix(len(unit), *G)
    A = sparse.csr_matrix(A[::-1], shape=(len(right) - len(unit), len(q))).tocsc() if len(right) > len(unit) else None
    return ScaledProgram(law, P, G, A, q, right, unit, share)


def _matrix(rows: int, start: Any, row: Any, value: Array) -> sparse.csc_matrix:
    return sparse.csc_matrix((value, row, start), shape=(rows, len(start) - 1))


@kernel
def _program(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, f_start, f_column, f_value, free, offset, f_bias, section, mu, b_f,
    scale, contact_velocity, units, from_free, alike, upper,
):  # fmt: skip
    """The fields of ScaledProgram but for the law, P, or its upper half, and G by columns and A by rows (start, row, value)."""
    p_start, q, g_start, g_row, g_value, h = matrices(
        start, column, J, m_start, m_column, m_value, free, offset, mu, b_f, section
    )
    nv, d, at, x = len(free), J.shape[1], len(free), np.zeros(len(q))
    if from_free:
        q[:nv], x[:nv] = 0.0, free
        for i in range(len(mu)):
            if b_f[i] > 0:
                x[at] = length(contact_velocity, i * d + 1, d - 1)
                at += 1
        for v in range(len(x)):
            for k in range(g_start[v], g_start[v + 1]):
                h[g_row[k]] -= g_value[k] * x[v]
    weight = 1 / np.where(mu > 0, np.minimum(1.0, np.maximum(LEAST_FRICTION, mu)), 1.0)
    diagonal, m = np.empty(nv), len(section)
    for v in range(nv):
        for k in range(m_start[v], m_start[v + 1]):
            if m_column[k] == v:
                diagonal[v] = m_value[k]
    if not alike:
        mass = np.exp(np.log(diagonal).mean())
        diagonal, scale = np.full(nv, mass), np.full(len(mu), 1 / mass)
    theta, share = size_and_share(scale, contact_velocity, units, weight)
    root = np.sqrt(np.append(scale, scale[b_f > 0]))  # 1/E, also of contacts' second blocks of rows, with a variable each
    D = np.append(1 / np.sqrt(diagonal), root[len(scale) :])
    unit, right, A = np.empty(len(h)), np.empty(len(h) + len(f_bias)), f_value * D[f_column]
    P, row, begins, at = np.empty(len(m_value)), np.empty(len(m_value), np.int32), np.zeros(len(q) + 1, np.int32), 0
    for j in range(len(q)):
        q[j] = D[j] * q[j] / theta
        for k in range(p_start[j], p_start[j + 1]):
            if m_column[k] <= j or not upper:
                P[at], row[at] = m_value[k] * D[j] * D[m_column[k]], m_column[k]
                at += 1
        begins[j + 1] = at
        for k in range(g_start[j], g_start[j + 1]):
            g_value[k] = g_value[k] * D[j] * (1 / root[g_row[k] // m])
    for i in range(len(h)):
        right[i], unit[i] = h[i] / root[i // m] / theta, theta / root[i // m]
    for j in range(len(f_bias)):
        left, square = -f_bias[j], 0.0
        for k in range(f_start[j], f_start[j + 1]):
            left -= f_value[k] * x[f_column[k]]
            square += A[k] ** 2
        E = 1 / np.sqrt(square) if square > 0 else 1.0
        right[len(h) + j] = left * E / theta
        for k in range(f_start[j], f_start[j + 1]):
            A[k] *= E
    return (begins, row[:at], P[:at]), (g_start, g_row, g_value), (f_start, f_column, A), q, right, unit, share


@kernel
def _dense(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, f_start, f_column, f_value, free, offset, f_bias, section, mu, b_f,
    scale, contact_velocity, units, from_free, alike,
):  # fmt: skip
    """The fields of ScaledProgram but for the law, with dense matrices."""
    (p_start, p_row, p_value), (g_start, g_row, g_value), (_, _, a_value), q, right, unit, share = _program(
        start, column, J, m_start, m_column, m_value, f_start, f_column, f_value, free, offset, f_bias, section, mu, b_f,
        scale, contact_velocity, units, from_free, alike, False,
    )  # fmt: skip
    n, joints = len(q), len(f_bias)
    P, G, A = np.zeros((n, n)), np.zeros((len(right) - joints, n)), np.zeros((joints, n))
    for j in range(n):
        for k in range(p_start[j], p_start[j + 1]):
            P[p_row[k], j] = p_value[k]
        for k in range(g_start[j], g_start[j + 1]):
            G[g_row[k], j] = g_value[k]
    for i in range(joints):
        for k in range(f_start[i], f_start[i + 1]):
            A[i, f_column[k]] = a_value[k]
    return P, G, A, q, right, unit, share


@kernel
def _above(start, row, value, below_start, below_row, below_value, rows):  # type: ignore[no-untyped-def]
    """A matrix of so many rows above another, all by columns."""
    kept, at = np.zeros(len(start), np.int32), 0
    both_row, both = np.empty(len(row) + len(below_row), np.int32), np.empty(len(row) + len(below_row))
    for j in range(len(start) - 1):
        for k in range(start[j], start[j + 1]):
            both_row[at], both[at] = row[k], value[k]
            at += 1
        for k in range(below_start[j], below_start[j + 1]):
            both_row[at], both[at] = rows + below_row[k], below_value[k]
            at += 1
        kept[j + 1] = at
    return kept, both_row, both
