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
from functools import cached_property
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.problems.forms.relaxation import QP, ConeProgram, Program
from frictionbench.problems.rows import Rows
from frictionbench.solvers.interface import Answer, Status, impulses

LEAST_FRICTION = 0.01
Kind = TypeVar("Kind", QP, ConeProgram)


@dataclass(frozen=True, eq=False)
class ScaledProgram(Generic[Kind]):
    """The scaled program: objective and bounds are P and G by columns (start, row, value), A is None without joints.

    share: eps over tol. unit: of the multipliers of G.
    """

    program: Kind
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

    @cached_property
    def upper(self) -> sparse.csc_matrix:
        """The upper half of P."""
        return _matrix(Rows(*_upper(*self.objective)), len(self.q))

    @cached_property
    def constraints(self) -> sparse.csc_matrix:
        """G above A."""
        return self.G if self.A is None else sparse.vstack([self.G, self.A], format="csc")

    @property
    def dense(self) -> tuple[Array, Array, Array]:
        """P, G and A dense, in C order; A has no rows without joints."""
        A = np.zeros((0, len(self.q))) if self.A is None else self.A.toarray(order="C")
        return _dense(*self.objective, len(self.q)), _dense(*self.bounds, len(self.h)), A

    def impulse(self, z: Array) -> Array:
        """The contact impulses (nc, d) of scaled multipliers of G."""
        return self.program.impulse(self.unit * z)

    def multipliers(self, impulse: Array) -> Array:
        """Scaled multipliers of G that make about these planar impulses, for a warm start; the friction bias is ignored."""
        impulse = impulses(impulse, (len(self.program.friction), 2))
        n, slip = impulse[:, 0], impulse[:, 1] / np.where(self.program.friction > 0, self.program.friction, 1.0)
        z = np.zeros(len(self.h))
        z[: 2 * len(n)] = np.maximum(np.column_stack([n + slip, n - slip]).ravel() / 2, 0.0)
        return z / self.unit

    def answer(
        self, z: Array | None, solved: bool, iterations: int | None = None, detail: str = "", clock: float | None = None
    ) -> Answer:
        """The answer of scaled multipliers, of which the first belong to G; None where the library returned nothing."""
        nothing = z is None or not len(z)
        impulse = np.zeros(self.program.contacts) if nothing else self.impulse(z[: len(self.h)])  # type: ignore[index]
        work = {} if iterations is None else {"iterations": iterations}
        return Answer(impulse, Status.SOLVED if solved else Status.FAILED, work, detail=detail, clock=clock)


class Prepared(NamedTuple):
    """The scaled program, and what the library is given: its arguments, after setup its object."""

    scaled: Any
    given: Any


class RelaxationSolver:
    """The steps that all libraries of the relaxation share; without contacts none of them is called."""

    def create(self, formed: Prepared) -> Any:
        """The library's object; by default it has none."""
        return formed.given

    def solve_scaled(self, prepared: Prepared, eps: float, limit: int | None, start: Array | None) -> Answer:
        """Solve to eps, the tolerance in the units of the scaled program."""
        raise NotImplementedError

    def setup(self, formed: Prepared) -> Prepared:
        return Prepared(formed.scaled, self.create(formed)) if formed.scaled.program.contacts[0] else formed

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        scaled = prepared.scaled
        if not scaled.program.contacts[0]:
            return scaled.answer(None, True)
        return self.solve_scaled(prepared, tol * scaled.share, limit, start)


def gap_tolerance(eps: float, least: float) -> float:
    """The duality gap at which errors are below eps, or the least that the library reaches."""
    return max(eps**2, least)


def scaled_program(problem: FrictionProblem, program: Kind, from_free: bool = False) -> ScaledProgram[Kind]:
    """Scale a problem's relaxation, as a QP or as a cone program.

    from_free: x* as above, for libraries that stop by a duality gap; otherwise x* = 0. First-order methods start from x^ = 0
    and regularised ones are drawn to it, and rest is nearer to most answers than free motion.
    """
    objective, bounds, m = program.objective, program.bounds, len(program.section)
    D, rows, theta, share = _units(
        problem.scale,
        program.friction,
        program.friction_bias,
        problem.q,
        problem.relaxation_units,
        *problem.mass_rows,
        m,
        problem.dimension,
    )
    A, joint = _joints(program, D)
    q, h, b = program.q, program.h, program.b
    if from_free:
        free = _free(problem.free_velocity, problem.q, program.friction_bias, problem.dimension)
        q, h = _from_free(q, h, *bounds, free, len(problem.free_velocity))
        b = b - program.A @ free if len(b) else b
    P, linear, G, right, unit = _scaled(*objective, q, *bounds, h, D, rows, theta)
    return ScaledProgram(
        program,
        # a copy, as some libraries require writable arrays and the columns of the mass matrix belong to the problem
        Rows(objective.start, objective.column.copy(), P),
        linear,
        Rows(bounds.start, bounds.column, G),
        right,
        A,
        b * joint / theta,
        unit,
        share,
    )


def scaled_relaxation(problem: FrictionProblem, from_free: bool = False) -> ScaledProgram[QP] | ScaledProgram[ConeProgram]:
    """The scaled QP in the plane and cone program in space."""
    if problem.dimension == 2:
        return scaled_program(problem, problem.qp(), from_free)
    return scaled_program(problem, problem.cone(), from_free)


def _matrix(columns: Rows, rows: int) -> sparse.csc_matrix:
    return sparse.csc_matrix((columns.value, columns.column, columns.start), shape=(rows, len(columns.start) - 1))


def _joints(program: Program, D: Array) -> tuple[sparse.csc_matrix | None, Array]:
    """A^, and E_A (nj,); None where there are no joints."""
    if not len(program.b):
        return None, np.ones(0)
    length = np.sqrt((program.A * D).power(2).sum(axis=1))
    joint = 1 / np.where(length > 0, length, 1.0)
    return sparse.csc_matrix(program.A * D * joint[:, None]), joint


@kernel
def _free(velocity, q, friction_bias, d):  # type: ignore[no-untyped-def]
    """x*: the free velocity, and the free tangential velocity of each contact with a friction bias."""
    nc, nv, at = len(friction_bias), len(velocity), len(velocity)
    free = np.empty(nv + nc)
    free[:nv] = velocity
    for i in range(nc):
        if friction_bias[i] > 0:
            square = 0.0
            for a in range(1, d):
                square += q[i * d + a] * q[i * d + a]
            free[at] = np.sqrt(square)
            at += 1
    return free[:at]


@kernel
def _from_free(q, h, start, row, value, free, nv):  # type: ignore[no-untyped-def]
    """q + P x*, which is 0 on velocities, and h - G x*."""
    linear, bounds = q.copy(), h.copy()
    linear[:nv] = 0.0
    for v in range(len(free)):
        for k in range(start[v], start[v + 1]):
            bounds[row[k]] -= value[k] * free[v]
    return linear, bounds


@kernel
def _scaled(p_start, p_row, p_value, q, g_start, g_row, g_value, h, D, rows, theta):  # type: ignore[no-untyped-def]
    """The values of P^ and of G^, q^, h^ and the unit of the multipliers; rows is 1/E on the rows of G."""
    P, G, linear = np.empty(len(p_value)), np.empty(len(g_value)), np.empty(len(q))
    right, unit = np.empty(len(h)), np.empty(len(h))
    for j in range(len(q)):
        linear[j] = D[j] * q[j] / theta
        for k in range(p_start[j], p_start[j + 1]):
            P[k] = p_value[k] * D[j] * D[p_row[k]]
        for k in range(g_start[j], g_start[j + 1]):
            G[k] = g_value[k] * D[j] * (1 / rows[g_row[k]])
    for i in range(len(h)):
        right[i], unit[i] = h[i] / rows[i] / theta, theta / rows[i]
    return P, linear, G, right, unit


@kernel
def _units(scale, mu, friction_bias, q, units, m_start, m_column, m_value, m, d):  # type: ignore[no-untyped-def]
    """D, 1/E on the rows of G, theta and share."""
    nc, nv, wide, least, theta = len(scale), len(m_start) - 1, 0, np.inf, 0.0
    for i in range(nc):
        wide += friction_bias[i] > 0
    D, rows = np.ones(nv + wide), np.empty((nc + wide) * m)
    for v in range(nv):
        for k in range(m_start[v], m_start[v + 1]):
            if m_column[k] == v:
                D[v] = 1 / np.sqrt(m_value[k])
    block = nc
    for i in range(nc):
        root, square = np.sqrt(scale[i]), 0.0
        for a in range(d):
            square += q[i * d + a] * q[i * d + a]
        slip = min(1.0, max(mu[i], LEAST_FRICTION)) if mu[i] > 0 else 1.0
        least = min(least, slip * units[i] / root)
        speed = np.sqrt(square)
        theta = max(theta, (speed if q[i * d] <= 0 else min(speed, units[i])) / root)
        for k in range(m):
            rows[i * m + k] = root
        if friction_bias[i] > 0:
            D[nv + block - nc] = root
            for k in range(m):
                rows[block * m + k] = root
            block += 1
    theta = theta if theta > 0 else 1.0
    return D, rows, theta, min(1.0, least / theta) if 0 < least < np.inf else 1.0


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
    """A matrix by columns, dense."""
    dense = np.zeros((rows, len(start) - 1))
    for j in range(len(start) - 1):
        for k in range(start[j], start[j + 1]):
            dense[row[k], j] = value[k]
    return dense
