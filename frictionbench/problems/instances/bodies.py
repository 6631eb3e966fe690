"""The friction problem of bodies, given by masses, contact points and contact frames, in the plane by angles of normals.

A body in space has six velocities, (v, omega) of its centre of mass. Let bodies a and b have a contact at x_a and x_b from
their centres, whose frame has the rows e = n, t1, t2, with n towards a. Its relative velocity along e is

    e.v_a + (x_a x e).omega_a - e.v_b - (x_b x e).omega_b.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.rows import Index64, planar_relative, relative
from frictionbench.problems.scene import GRAVITY

GROUND = -1  # the index of the ground as the second body of a contact


def touching(
    bodies: Index64,
    arms: Array,
    frame: Array,
    weights: Array,
    velocity: Array,
    friction: float | Array,
    joints: sparse.csr_array | None = None,
) -> FrictionProblem:
    """The problem of nc contacts between nb bodies.

    bodies: (nc, 2), the second may be GROUND. arms: (nc, 2, 3). frame: (nc, 3, 3), rows n, t1, t2. weights: (nb, 6), the mass
    matrix's diagonal. velocity: (nb, 6), the free velocity. friction: one for all contacts or (nc,). joints:
    (nj, 6 nb), none by default.
    """
    nc, spins = len(bodies), np.cross(arms[:, None], frame[:, :, None])
    return FrictionProblem(
        mass=sparse.diags_array(weights.ravel()),
        normal=relative(bodies, frame[:, :1], spins[:, :1]),
        tangent=relative(bodies, frame[:, 1:], spins[:, 1:]),
        friction=np.broadcast_to(friction, nc),
        free_velocity=velocity.ravel(),
        bias=np.zeros(nc),
        joints=joints,
        joint_bias=None if joints is None else np.zeros(joints.shape[0]),
        dimension=3,
    )


def touching_in_plane(
    bodies: Index64, arms: Array, angle: Array, weights: Array, velocity: Array, friction: Array, bias: Array | float = 0.0
) -> FrictionProblem:
    """The problem of nc contacts between nb planar bodies, of three velocities each.

    arms: (nc, 2, 2). angle: (nc,), of the normals. bias: m/s. Other arguments: as in touching.
    """
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
    return FrictionProblem(
        mass=sparse.diags_array(weights.ravel()),
        normal=planar_relative(bodies, arms, normal),
        tangent=planar_relative(bodies, arms, tangent),
        friction=friction,
        free_velocity=velocity,
        bias=np.broadcast_to(bias, len(bodies)),
    )


def falling(bodies: int, step: float) -> Array:
    """The free velocities (nb, 6) of bodies at rest after one step of gravity."""
    velocity = np.zeros((bodies, 6))
    velocity[:, 2] = -GRAVITY * step
    return velocity
