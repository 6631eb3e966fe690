"""The friction problem of spatial bodies, given by masses, contact points and contact frames.

A body has six velocities, (v, omega) of its centre of mass. A contact between bodies a and b at arms x_a, x_b from their
centres, with the frame of rows e = n, t1, t2 (n towards a), moves along e at

    e.v_a + (x_a x e).omega_a - e.v_b - (x_b x e).omega_b.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.rows import Index64
from frictionbench.problems.scene import GRAVITY

GROUND = -1  # as the second body of a contact


def touching(
    bodies: Index64,
    arms: Array,
    frame: Array,
    weights: Array,
    velocity: Array,
    friction: float | Array,
    bias: Array | None = None,
    joints: sparse.csr_array | None = None,
) -> FrictionProblem:
    """The problem of nc contacts between nb bodies.

    bodies: (nc, 2), the second may be GROUND. arms: (nc, 2, 3). frame: (nc, 3, 3), rows n, t1, t2. weights: (nb, 6), the mass
    matrix's diagonal. velocity: (nb, 6), the free one. friction: one for all or (nc,). bias: (nc,), none by default.
    joints: (nj, 6 nb), none by default.
    """
    nc, nb = len(bodies), len(weights)
    row, column, value = [], [], []
    for side, sign in ((0, 1.0), (1, -1.0)):
        held = np.flatnonzero(bodies[:, side] != GROUND)
        spin = np.cross(arms[held, side][:, None, :], frame[held])  # (held, 3 rows, 3)
        row.append(np.broadcast_to(3 * held[:, None, None] + np.arange(3)[:, None], (len(held), 3, 6)).ravel())
        column.append(np.broadcast_to(6 * bodies[held, side][:, None, None] + np.arange(6), (len(held), 3, 6)).ravel())
        value.append(sign * np.concatenate([frame[held], spin], axis=2).ravel())
    places = np.concatenate(row), np.concatenate(column)
    jacobian = sparse.csr_array(sparse.coo_array((np.concatenate(value), places), shape=(3 * nc, 6 * nb)))
    normal = np.arange(3 * nc) % 3 == 0
    return FrictionProblem(
        mass=sparse.diags_array(weights.ravel()),
        normal=jacobian[normal],
        tangent=jacobian[~normal],
        friction=np.broadcast_to(friction, nc),
        free_velocity=velocity.ravel(),
        bias=np.zeros(nc) if bias is None else bias,
        joints=joints,
        joint_bias=None if joints is None else np.zeros(joints.shape[0]),
        dimension=3,
    )


def falling(bodies: int, step: float) -> Array:
    """The free velocities (nb, 6) of bodies at rest after one step of gravity."""
    velocity = np.zeros((bodies, 6))
    velocity[:, 2] = -GRAVITY * step
    return velocity
