"""The convex relaxation of a friction problem (Anitescu 2006; Anitescu and Tasora 2010).

Coulomb's law without de Saxcé's shift: -u in the normal cone of K at r, which are the optimality conditions of

    min  ½ v'Mv - (M v*)'v + b_f'y    subject to    u = J v + offset,   F v + b_F = 0,
         u_n >= mu |u_t|  at every contact,    y_i >= |u_t,i|  at contacts with b_f,i > 0.

The multipliers are the impulses. A sliding contact separates at u_n = mu |u_t|: the model's error, whatever the solver.
In the plane and with a polygonal section the constraints are linear; the slack y, one for each contact with a friction
bias, carries the segment by which that contact's set K is wider than a cone.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse

from problems.check import Array


class VelocityForm(NamedTuple):
    """A friction problem in its velocities, joints apart: M (v - v*) = J' r, u = J v + offset."""

    mass: sparse.csr_array
    inverse: sparse.csr_array
    jacobian: sparse.csr_array
    free_velocity: Array
    offset: Array


class Laws(NamedTuple):
    """What else a friction problem says: its cones |r_t| <= mu r_n + b_f (nc), its joints F v + b_F = 0, and d."""

    friction: Array
    friction_bias: Array
    joints: sparse.csr_array
    joint_bias: Array
    dimension: int


@dataclass(frozen=True, eq=False)
class QP:
    """min ½ x'Px + q'x subject to G x <= h and A x = b; impulse(z) turns the multipliers z >= 0 of G into (nc, d) impulses."""

    P: sparse.csc_array
    q: Array
    G: sparse.csc_array
    h: Array
    A: sparse.csc_array
    b: Array
    to_impulse: sparse.csr_array
    contacts: tuple[int, int]

    def impulse(self, z: Array) -> Array:
        return np.asarray(self.to_impulse @ z).reshape(self.contacts)


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """min ½ x'Px + q'x subject to A x = b and h - G x in second-order cones {s_0 >= |s_1:|}, blocks of the given sizes.

    impulse(z) turns the cone multipliers z of G into (nc, d) impulses.
    """

    P: sparse.csc_array
    q: Array
    G: sparse.csc_array
    h: Array
    sizes: tuple[int, ...]
    A: sparse.csc_array
    b: Array
    to_impulse: sparse.csr_array
    contacts: tuple[int, int]

    def impulse(self, z: Array) -> Array:
        return np.asarray(self.to_impulse @ z).reshape(self.contacts)


def relaxation_qp(form: VelocityForm, laws: Laws, facets: int) -> QP:
    """The relaxation with a polygonal section (exact in the plane) as a QP in x = (v, y)."""
    nc, d = len(laws.friction), laws.dimension
    if d == 2:
        section = np.array([[1.0], [-1.0]])
    else:
        angle = 2 * np.pi * np.arange(facets) / facets
        section = np.column_stack([np.cos(angle), np.sin(angle)])
    K = len(section)
    # Facet rows (1, mu d_k) of every contact: u_n + mu d_k'u_t >= 0. Their multipliers add up to the impulse.
    facet = _blocks(np.ones((nc, K, 1)), laws.friction[:, None, None] * section)
    # Slack rows y + d_k'u_t >= 0, for contacts with a friction bias only.
    wide = np.flatnonzero(laws.friction_bias)
    segment = _blocks(np.zeros((nc, K, 1)), np.broadcast_to(section, (nc, K, d - 1)))
    segment = segment[(wide[:, None] * K + np.arange(K)).ravel()]
    slack = sparse.kron(sparse.eye_array(len(wide)), np.ones((K, 1)))
    return QP(*_program(form, laws, facet, segment, slack), contacts=(nc, d))


def relaxation_cone(form: VelocityForm, laws: Laws) -> ConeProgram:
    """The relaxation with the circular section as a second-order cone program in x = (v, y)."""
    nc, d = len(laws.friction), laws.dimension
    mu = np.broadcast_to(laws.friction[:, None, None], (nc, d, 1))
    identity = np.broadcast_to(np.eye(d), (nc, d, d))
    # Rows (u_n, mu u_t) of every contact lie in the cone; (y, u_t) of those with a friction bias too.
    facet = _blocks(identity[:, :, :1], identity[:, :, 1:] * mu)
    wide = np.flatnonzero(laws.friction_bias)
    segment = _blocks(np.zeros((nc, d, 1)), identity[:, :, 1:])[(wide[:, None] * d + np.arange(d)).ravel()]
    slack = sparse.kron(sparse.eye_array(len(wide)), np.eye(d)[:, :1])
    P, q, G, h, A, b, to_impulse = _program(form, laws, facet, segment, slack)
    return ConeProgram(P, q, G, h, (d,) * (nc + len(wide)), A, b, to_impulse, (nc, d))


_Program = tuple[sparse.csc_array, Array, sparse.csc_array, Array, sparse.csc_array, Array, sparse.csr_array]


def _program(
    form: VelocityForm, laws: Laws, facet: sparse.csr_array, segment: sparse.csr_array, slack: sparse.coo_array
) -> _Program:
    """P, q, G, h, A, b and the map from multipliers to impulses, for the constraint rows facet @ u and segment @ u + y."""
    mass, _, jacobian, free, offset = form
    ny = slack.shape[1]
    on_contacts = sparse.csr_array(sparse.vstack([facet, segment]))
    on_slack = sparse.vstack([sparse.csr_array((facet.shape[0], ny)), slack])
    G = -sparse.hstack([on_contacts @ jacobian, on_slack], format="csc")
    P = sparse.block_diag([mass, sparse.csr_array((ny, ny))], format="csc")
    A = sparse.hstack([laws.joints, sparse.csr_array((laws.joints.shape[0], ny))], format="csc")
    q = np.concatenate([-(mass @ free), laws.friction_bias[laws.friction_bias > 0]])
    return P, q, G, on_contacts @ offset, A, -laws.joint_bias, sparse.csr_array(on_contacts.T)


def _blocks(normal: Array, tangent: Array) -> sparse.csr_array:
    """Block diagonal matrix with a block [normal | tangent] of shape (rows, d) for every contact."""
    block = np.concatenate([normal, tangent], axis=2)
    nc, rows, d = block.shape
    if not nc:
        return sparse.csr_array((0, 0))
    return sparse.csr_array(sparse.bsr_array((block, np.arange(nc), np.arange(nc + 1)), shape=(nc * rows, nc * d)))
