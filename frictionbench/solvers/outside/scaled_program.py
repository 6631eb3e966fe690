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

Matrices are written in compiled passes and become scipy's, or dense, only as a library takes them.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.problems.forms.relaxation import Program
from frictionbench.problems.rows import Rows, row_of_entry
from frictionbench.solvers.interface import Answer, Status, impulses, solver
from frictionbench.solvers.outside.scaled_delassus import size_and_share

LEAST_FRICTION = 0.01
relaxation_library = partial(solver, family="relaxation", model="relaxation", lacks=("asymmetry",))  # registers an adapter


@dataclass(frozen=True, eq=False)
class ScaledProgram:
    """The scaled program: objective and bounds are P and G by columns (start, row, value), A is None without joints.

    share: eps over tol. unit: of the multipliers of G.
    """

    program: Program
    objective: Rows
    q: Array
    bounds: Rows
    h: Array
    A: sparse.csc_matrix | None
    b: Array
    unit: Array
    share: float

    @cached_property
    def P(self) -> sparse.csc_matrix:
        return _matrix(self.objective, len(self.q))

    @cached_property
    def G(self) -> sparse.csc_matrix:
        return _matrix(self.bounds, len(self.h))

    @property
    def upper(self) -> sparse.csc_matrix:
        """The upper half of P."""
        return _matrix(Rows(*_upper(*self.objective)), len(self.q))

    @property
    def constraints(self) -> sparse.csc_matrix:
        """G above A."""
        return self.G if self.A is None else sparse.vstack([self.G, self.A], format="csc")

    def limits(self, least: float) -> tuple[Array, Array]:
        """Of the constraints' rows, from below and above; `least` for those of G, which have none from below."""
        return np.concatenate([np.full(len(self.h), least), self.b]), np.concatenate([self.h, self.b])

    def matrices(self, dense: bool) -> tuple[Any, Any, Any, Array | None]:
        """P, G, A and b, dense in C order or sparse; A and b are None without joints."""
        b = None if self.A is None else self.b
        if not dense:
            return self.P, self.G, self.A, b
        A = None if self.A is None else self.A.toarray(order="C")
        return _dense(*self.objective, len(self.q)), _dense(*self.bounds, len(self.h)), A, b

    def dense(self) -> tuple[Array, Array]:
        """P, and G above A."""
        P, G, A, _ = self.matrices(dense=True)
        return P, G if A is None else np.vstack([G, A])

    def multipliers(self, impulse: Array) -> Array:
        """Scaled multipliers of G that make about these planar impulses, for a warm start; the friction bias is ignored."""
        impulse = impulses(impulse, self.program.contacts)
        n, slip = impulse[:, 0], impulse[:, 1] / np.where(self.program.friction > 0, self.program.friction, 1.0)
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
        impulse = np.zeros(self.program.contacts) if nothing else self.program.impulse(self.unit * z[: len(self.h)])  # type: ignore[index]
        work = {} if iterations is None else {"iterations": iterations}
        return Answer(impulse, Status.SOLVED if solved else Status.FAILED, work, detail=detail, clock=clock)


def scaled_program(problem: FrictionProblem, from_free: bool = False) -> ScaledProgram:
    """Scale a problem's relaxation, the QP in the plane and the cone program in space.

    from_free: x* as above, for libraries that stop by a duality gap; otherwise x* = 0. First-order methods start from x^ = 0
    and regularised ones are drawn to it, and rest is nearer to most answers than free motion.
    """
    program = problem.qp() if problem.dimension == 2 else problem.cone()
    objective, bounds, mu, b_f = program.objective, program.bounds, program.friction, program.friction_bias
    moving = problem.scale, problem.q, problem.relaxation_units
    q, h, b = program.q, program.h, program.b
    if from_free:
        q, h, free = _from_free(q, h, *bounds, problem.free_velocity, problem.q, b_f)
        b = b - program.A @ free if len(b) else b
    D, P, q, G, h, unit, theta, share = _scaled(*objective, q, *bounds, h, *moving, mu, b_f)
    A, joint = _joints(program, D)
    # a copy, as some libraries require writable arrays and the columns of the mass matrix belong to the problem
    P = Rows(objective.start, objective.column.copy(), P)
    return ScaledProgram(program, P, q, Rows(bounds.start, bounds.column, G), h, A, b * joint / theta, unit, share)


def _matrix(columns: Rows, rows: int) -> sparse.csc_matrix:
    return sparse.csc_matrix((columns.value, columns.column, columns.start), shape=(rows, len(columns.start) - 1))


def _joints(program: Program, D: Array) -> tuple[sparse.csc_matrix | None, Array]:
    """A^, and E_A (nj,); None where there are no joints."""
    if not len(program.b):
        return None, np.ones(0)
    start, column, value = program.joints
    value, row = value * D[column], row_of_entry(start)
    length = np.sqrt(np.bincount(row, value**2, len(program.b)))
    joint = 1 / np.where(length > 0, length, 1.0)
    return sparse.csr_matrix((value * joint[row], column, start), shape=(len(length), len(D))).tocsc(), joint


@kernel
def _from_free(q, h, start, row, value, velocity, contact_velocity, friction_bias):  # type: ignore[no-untyped-def]
    """q + P x*, which is 0 on velocities, h - G x* and x*: the free velocity, and the free tangential velocity of each contact
    with a friction bias."""
    nv, d, at = len(velocity), len(contact_velocity) // len(friction_bias), len(velocity)
    linear, bounds, free = q.copy(), h.copy(), np.empty(len(q))
    linear[:nv], free[:nv] = 0.0, velocity
    for i in range(len(friction_bias)):
        if friction_bias[i] > 0:
            square = 0.0
            for a in range(1, d):
                square += contact_velocity[i * d + a] ** 2
            free[at] = np.sqrt(square)
            at += 1
    for v in range(len(free)):
        for k in range(start[v], start[v + 1]):
            bounds[row[k]] -= value[k] * free[v]
    return linear, bounds, free


@kernel
def _scaled(  # type: ignore[no-untyped-def]
    p_start, p_row, p_value, q, g_start, g_row, g_value, h, scale, contact_velocity, units, friction, friction_bias
):
    """D, the values of P^, q^, the values of G^, h^, the unit of the multipliers, theta and share."""
    weight = 1 / np.where(friction > 0, np.minimum(1.0, np.maximum(LEAST_FRICTION, friction)), 1.0)
    theta, share = size_and_share(scale, contact_velocity, units, weight)
    wide = scale[friction_bias > 0]  # of the contacts that have a second block of rows, and a variable
    root = np.sqrt(np.append(scale, wide))  # 1/E
    m, D = len(h) // len(root), np.ones(len(q))
    P, G, linear = np.empty(len(p_value)), np.empty(len(g_value)), np.empty(len(q))
    for v in range(len(q)):
        for k in range(p_start[v], p_start[v + 1]):
            if p_row[k] == v:
                D[v] = 1 / np.sqrt(p_value[k])
    D[len(q) - len(wide) :] = root[len(scale) :]
    for j in range(len(q)):
        linear[j] = D[j] * q[j] / theta
        for k in range(p_start[j], p_start[j + 1]):
            P[k] = p_value[k] * D[j] * D[p_row[k]]
        for k in range(g_start[j], g_start[j + 1]):
            G[k] = g_value[k] * D[j] * (1 / root[g_row[k] // m])
    right, unit = np.empty(len(h)), np.empty(len(h))
    for i in range(len(h)):
        right[i], unit[i] = h[i] / root[i // m] / theta, theta / root[i // m]
    return D, P, linear, G, right, unit, theta, share


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
def _dense(start, row, value, rows):  # type: ignore[no-untyped-def]
    """A matrix by columns, dense in C order."""
    dense = np.zeros((rows, len(start) - 1))
    for j in range(len(start) - 1):
        for k in range(start[j], start[j + 1]):
            dense[row[k], j] = value[k]
    return dense
