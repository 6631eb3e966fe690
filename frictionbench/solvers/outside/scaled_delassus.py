"""The dimensionless Delassus form, in which the tolerances of all outside libraries have the same meaning.

With E_i = 1/sqrt(s_i) on contact i's rows and theta = max_i |q_i| E_i over contacts that close and unit_i E_i over those that
open, unit_i that of problems.residual, r = theta E r^ turns u = W r + q into

    u^ = W^ r^ + q^,      W^ = E W E,      q^ = E q / theta,

a mean diagonal of 1 at every contact, free velocities of at most 1 but where a contact is open by far, the same cones. An error
of the natural map of eps at a contact, |r^_i - P_K(r^_i - g(u^_i))| <= eps, is an error of eps theta sqrt(s_i) in contact
velocity and of at most sqrt(1 + mu_i^2) times that of Signorini's condition, which the residual measures too. So

    eps = share * tol,      share = min_i unit_i / (theta sqrt(s_i) sqrt(1 + mu_i^2)) <= 1,

keeps the residual of problems.residual within tol. With a `size` c, W^ is c E W E and r^ by c smaller, q^ the same: a library's
constants may prefer that, and an error of r^ then counts c times.

W^ and q^ are written in compiled passes, in the order and with as many rows a contact as the library takes: `rows` are the
places of a contact's components (n, t) or (n, t1, t2) among its rows. In the plane a library of contacts in space gets three
rows; the third is decoupled, with the tangent's diagonal. W^ is dense or, as `entries`, sparse.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.interface import Answer, Status, impulses

PLANE, SPACE, TANGENTS_FIRST = (0, 1), (0, 1, 2), (2, 0, 1)
_NOT_WRITTEN = np.zeros((0, 0))


class ScaledDelassus(NamedTuple):
    """W^ (nc*m, nc*m), q^ (nc*m,), friction (nc,), E (nc,), theta, share, s (nc,), (nc, d) and rows, m of them a contact."""

    W: Array
    q: Array
    friction: Array
    E: Array
    theta: float
    share: float
    scale: Array
    contacts: tuple[int, int]
    rows: tuple[int, ...]

    def impulse(self, r: Array) -> Array:
        """The impulses (nc, d), N s, for r^ (nc*m,)."""
        impulse: Array = _impulses(r, self.E, self.theta, self.rows, self.contacts[1])
        return impulse

    def answer(self, r: Array, status: Status, detail: str = "", clock: float | None = None, **work: int) -> Answer:
        """The answer of r^ (nc*m,)."""
        return Answer(self.impulse(r), status, work, detail=detail, clock=clock)

    def guess(self, impulse: Array) -> Array:
        """r^ (nc*m,) of impulses (nc, d). Errors: InputError naming start."""
        nc, d = self.contacts
        r = np.zeros((nc, len(self.rows)))
        r[:, self.rows[:d]] = impulses(impulse, self.contacts) / (self.theta * self.E)[:, None]
        return r.ravel()


def scaled_delassus(
    problem: FrictionProblem,
    rows: tuple[int, ...] | None = None,
    *,
    matrix: bool = True,
    size: float = 1.0,
    relaxed: bool = False,
) -> ScaledDelassus:
    """The dimensionless Delassus form of a friction problem, without its friction_bias.

    rows: as above, the d components in order by default. matrix: whether W^ is written; (0, 0) otherwise. size: the mean
    diagonal of W^ at every contact. relaxed: measured in the units of the convex relaxation.
    """
    nc, d = problem.contacts, problem.dimension
    places, units = rows or (PLANE if d == 2 else SPACE), problem.relaxation_units if relaxed else problem.units
    E, q, theta, share = _scaled_vector(problem.scale, problem.friction, problem.q, units, d, places, size)
    W = _dense(*problem.blocks, E, places) if matrix else _NOT_WRITTEN
    return ScaledDelassus(W, q, problem.friction, E, theta, share, problem.scale, (nc, d), places)


@kernel
def _scaled_vector(scale, mu, q, units, d, rows, size):  # type: ignore[no-untyped-def]
    """E, q^, theta and share."""
    nc, m, root = len(scale), len(rows), np.sqrt(size)
    theta, share = size_and_share(scale, q, units, np.sqrt(1 + mu**2))
    E, scaled = 1 / np.sqrt(scale), np.zeros(nc * m)
    for i in range(nc):
        for a in range(d):
            scaled[i * m + rows[a]] = E[i] * q[i * d + a] / theta
    return root * E, scaled, root * theta, share


@kernel
def _impulses(r, E, theta, rows, d):  # type: ignore[no-untyped-def]
    impulse, m = np.empty((len(E), d)), len(rows)
    for i in range(len(E)):
        for a in range(d):
            impulse[i, a] = theta * E[i] * r[i * m + rows[a]]
    return impulse


@part
def size_and_share(scale, q, units, weight):  # type: ignore[no-untyped-def]
    """theta, and eps over tol where the measure of contact i is weight_i times its scaled error: 1 where nothing moves."""
    nc, theta, least = len(scale), 0.0, np.inf
    d = len(q) // nc
    for i in range(nc):
        root, square = np.sqrt(scale[i]), 0.0
        for a in range(d):
            square += q[i * d + a] ** 2
        speed = np.sqrt(square)
        theta = max(theta, (speed if q[i * d] <= 0 else min(speed, units[i])) / root)
        least = min(least, units[i] / (root * weight[i]))
    theta = theta if theta > 0 else 1.0
    return theta, min(1.0, least / theta) if least > 0 else 1.0


@kernel
def _dense(first, neighbours, block, E, rows):  # type: ignore[no-untyped-def]
    """W^ dense, symmetric in memory order wherever W is."""
    nc, m, d = len(E), len(rows), block.shape[1]
    W = np.zeros((nc * m, nc * m))
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            j = neighbours[k]
            for a in range(d):
                for b in range(d):
                    W[i * m + rows[a], j * m + rows[b]] = E[i] * block[k, a, b] * E[j]
        for a in range(d, m):
            W[i * m + rows[a], i * m + rows[a]] = W[i * m + rows[1], i * m + rows[1]]
    return W


@kernel
def entries(first, neighbours, block, E, rows):  # type: ignore[no-untyped-def]
    """The entries (row, column, value) of W^ (k, 3), block by block, a decoupled tangent's after its contact's own block."""
    nc, m, d, at = len(E), len(rows), block.shape[1], 0
    triplets = np.empty((len(neighbours) * d**2 + nc * (m - d), 3))
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            j = neighbours[k]
            for a in range(m if i == j else d):
                for b in range(d) if a < d else range(a, m):
                    triplets[at, 0], triplets[at, 1] = i * m + rows[a], j * m + rows[b]
                    triplets[at, 2] = E[i] * block[k, min(a, d - 1), min(b, d - 1)] * E[j]
                    at += 1
    return triplets
