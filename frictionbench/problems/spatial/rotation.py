"""Rotations as unit quaternions (w, x, y, z), and the free rotation of a rigid body.

The spin of a body is given in its own frame, in which its inertia I is constant and diagonal:

    I w' + w x I w = torque,      R' = R [w],

where R is the rotation from the body's frame to the world's and [w] is the matrix of w x.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from frictionbench.problems.check import Array

NO_ROTATION = np.array([1.0, 0.0, 0.0, 0.0])  # the quaternion of no rotation
ITERATIONS = 8  # of Newton's method: more than a full turn in a step needs, because it converges quadratically


def matrices(quaternion: Array) -> Array:
    """The rotations (n, 3, 3) from the bodies' frames to the world's, for unit quaternions (n, 4)."""
    return np.asarray(Rotation.from_quat(quaternion, scalar_first=True).as_matrix())


def turned(quaternion: Array, way: Array) -> Array:
    """The unit quaternions (n, 4) after rotations by the vectors `way` (n, 3), rad, in the bodies' frames."""
    after = Rotation.from_quat(quaternion, scalar_first=True) * Rotation.from_rotvec(way)
    return np.asarray(after.as_quat(scalar_first=True))


def gyroscopic(inertia: Array, spin: Array, step: float) -> Array:
    """The mean gyroscopic torque (n, 3), N m, in a step: I (w+ - w) = -h w_m x I w_m with w_m = (w + w+)/2, w the free spins.

    The implicit midpoint rule conserves the energy and the norm of the angular momentum. inertia: (n, 3), kg m^2.
    """
    torque = np.zeros_like(spin)
    turning = np.flatnonzero((np.ptp(inertia, axis=1) > 0) & spin.any(axis=1))  # a sphere has no gyroscopic torque
    if not len(turning):
        return torque
    I, before = inertia[turning], spin[turning]  # noqa: E741  # the usual symbol of the inertia
    after = before.copy()
    for _ in range(ITERATIONS):
        middle = (before + after) / 2
        missing = I * (after - before) + step * np.cross(middle, I * middle)
        slope = np.eye(3) * I[:, None] + step / 2 * (_cross(middle) * I[:, None] - _cross(I * middle))
        after -= np.linalg.solve(slope, missing[..., None])[..., 0]
    torque[turning] = I * (after - before) / step
    return torque


def frames(normal: Array) -> Array:
    """An orthonormal frame (nc, 3, 3) for each unit normal (nc, 3), which is its first row."""
    least = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(normal, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([normal, first, np.cross(normal, first)], axis=1)


def _cross(a: Array) -> Array:
    """The matrices (n, 3, 3) of the cross products with a (n, 3)."""
    return np.cross(np.eye(3), -a[:, None])
