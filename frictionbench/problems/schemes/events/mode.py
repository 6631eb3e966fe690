"""A mode of contact: which contacts are closed, and whether each sticks or slides. Its forces solve linear equations.

The rows of G are the constraints: normals of closed contacts, tangents of sticking contacts, and joints. The rows of C are the
directions of their forces x, n - mu sign(t'v) t at a sliding contact. Then

    M a = k + C' x,      G a + G. v = 0,      A x = -(G M^-1 k + G. v),  A = G M^-1 C'.

For one sliding contact, A is Painlevé's p = n'M^-1 (n - mu sign(t'v) t). If A is rank-deficient, contacts are redundant: the
accelerations are determined, but the forces are not, and those of least norm are used.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.events.forces import rates

SINGULAR = 1e-9  # relative to A's largest singular value: smaller ones count as zero, and contacts are redundant


class Mode(NamedTuple):
    """features: (nc, 2), of the closed contacts. slip: (nc,), the sign of t'v at a sliding contact, 0 at a sticking one."""

    features: NDArray[np.int64]
    slip: NDArray[np.int64]

    def find(self, contacts: Contacts) -> tuple[Contacts, bool]:
        """The mode's contacts among the given ones, in the mode's order, and whether all were found."""
        place = {tuple(feature): i for i, feature in enumerate(contacts.feature.tolist())}
        index = [place[f] for f in map(tuple, self.features.tolist()) if f in place]
        return contacts.only(np.array(index, dtype=np.int64)), len(index) == len(self.features)


class Forces(NamedTuple):
    """a: (nv,). normal, tangential: (nc,), N. sign: of det A, 1 if redundant. redundant: whether the forces are undetermined.
    stiffness: (nc, 2), the diagonal of J M^-1 J', 1/kg."""

    a: Array
    normal: Array
    tangential: Array
    sign: float
    redundant: bool
    stiffness: Array


def _rows(scene: Scene, q: Array, contacts: Contacts) -> tuple[Array, Array, Array]:
    """Normals N (nc, nv), tangents T (nc, nv) and joints F (nj, nv)."""
    nv = len(q)
    joints = scene.joints(q)[1].toarray() if scene.hinges else np.zeros((0, nv))
    return contacts.normal_rows.dense(nv), contacts.tangent_rows.dense(nv), joints


def forces(scene: Scene, q: Array, v: Array, time: float, contacts: Contacts, mode: Mode) -> Forces:
    """The forces and accelerations in this mode, whether or not they satisfy the inequalities."""
    N, T, F = _rows(scene, q, contacts)
    sticks, nc = mode.slip == 0, len(contacts)
    rate = rates(scene, q, v, contacts)
    mu = scene.coefficients(contacts)
    G = np.vstack([N, T[sticks], F])
    C = np.vstack([N - (mu * mode.slip)[:, None] * T, T[sticks], F])
    moved = scene.accelerate(q, C.T) if len(C) else np.zeros((len(v), 0))
    free = scene.accelerate(q, scene.force(q, v, time))
    A, lacking = G @ moved, -(G @ free + np.concatenate([rate.normal, rate.tangent[sticks, 0], rate.joint]))
    x, _, rank, _ = np.linalg.lstsq(A, lacking, rcond=SINGULAR) if len(A) else (np.zeros(0), 0, 0, 0)
    tangential = -mu * mode.slip * x[:nc]
    tangential[sticks] = x[nc : nc + sticks.sum()]
    stiffness = np.column_stack([(rows.T * scene.accelerate(q, rows.T)).sum(axis=0) for rows in (N, T)])
    sign = 1.0 if rank < len(A) else float(np.linalg.slogdet(A)[0])
    return Forces(free + moved @ x, x[:nc], tangential, sign, rank < len(A), stiffness)


def project(scene: Scene, q: Array, v: Array, mode: Mode) -> tuple[Array, Array]:
    """The nearest state in the metric of M that satisfies the mode's constraints in positions and in velocities."""
    contacts, complete = mode.find(scene.contacts(q, 10 * scene.touch))
    theta = scene.joints(q)[0]
    if not complete or not (len(contacts) or len(theta)):
        return q, v
    N, T, F = _rows(scene, q, contacts)
    G = np.vstack([N, T[mode.slip == 0], F])
    off = np.concatenate([contacts.gap, np.zeros(int((mode.slip == 0).sum())), theta])
    moved = scene.accelerate(q, G.T)
    back = np.linalg.pinv(G @ moved, rcond=SINGULAR, hermitian=True)
    return q - moved @ (back @ off), v - moved @ (back @ (G @ v))
