"""A friction problem as contact-wise methods see it: a state x that every contact reads and pushes.

    u_i = offset_i + G_i x,        x = rest + sum_i R_i r_i,        G R = W.

Of a mechanical problem x holds the velocities, G = J and R = M^-1 J': a contact touches its two bodies only, so a sweep
over all contacts costs O(nc) operations and bytes, and W is never formed. With joints, or where only W is known, x holds
the impulses themselves, G = W and R = I.

Both are packed alike: contact i reads columns read_column[read_start[i]:read_start[i+1]] with d coefficients in each.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse

from problems import FrictionProblem
from problems.check import Array
from problems.friction import DelassusProblem

Index = NDArray[np.int32]


class ContactForm(NamedTuple):
    """Packed G (read) and R (push), one column of d coefficients an entry; nc contacts of dimension d, nx states.

    read_start, push_start: (nc+1,). read_column, push_column: (entries,). read, push: (entries, d).
    offset: (nc, d) and rest: (nx,). block: (nc, d, d), each contact's own block of W.
    friction, friction_bias, scale: (nc,), and free, max|q_i|: those of the problem and of its residual.
    """

    read_start: Index
    read_column: Index
    read: Array
    push_start: Index
    push_column: Index
    push: Array
    offset: Array
    rest: Array
    block: Array
    friction: Array
    friction_bias: Array
    scale: Array
    free: float


def contact_form(problem: FrictionProblem) -> ContactForm:
    """Pack a problem; in velocities where each contact touches few of them, in impulses otherwise."""
    nc, d = problem.contacts, problem.dimension
    if isinstance(problem, DelassusProblem) or problem.joints.shape[0]:
        G, offset = problem.W, problem.q
        R, rest = sparse.eye_array(nc * d, format="csr"), np.zeros(nc * d)
    else:
        _, inverse, G, rest, offset = problem.velocity_form()
        R = sparse.csr_array((inverse @ G.T).T)
    read, push = _pack(G, d), _pack(R, d)
    free = float(np.linalg.norm(problem.q.reshape(nc, d), axis=1).max(initial=0.0))
    block = _own_blocks(*read, *push, len(rest))
    law = (problem.friction.copy(), problem.friction_bias.copy(), problem.scale.copy())
    return ContactForm(*read, *push, offset.reshape(nc, d).copy(), rest.copy(), block, *law, free)


def _pack(rows: sparse.csr_array, d: int) -> tuple[Index, Index, Array]:
    """The rows of each contact over the union of their columns."""
    if not rows.shape[0]:
        return np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros((0, d))
    packed = sparse.csr_array(rows).tobsr(blocksize=(d, 1))
    return packed.indptr.astype(np.int32), packed.indices.astype(np.int32), np.ascontiguousarray(packed.data[:, :, 0])


@njit(cache=True)
def _own_blocks(read_start, read_column, read, push_start, push_column, push, nx):  # type: ignore[no-untyped-def]
    nc, d = len(read_start) - 1, read.shape[1]
    block, x = np.zeros((nc, d, d)), np.zeros(nx)
    for i in range(nc):
        for along in range(d):
            for k in range(push_start[i], push_start[i + 1]):
                x[push_column[k]] = push[k, along]
            for k in range(read_start[i], read_start[i + 1]):
                for j in range(d):
                    block[i, j, along] += read[k, j] * x[read_column[k]]
            for k in range(push_start[i], push_start[i + 1]):
                x[push_column[k]] = 0.0
    return block


@njit(cache=True)
def state(form, r, x):  # type: ignore[no-untyped-def]
    """x (nx,) anew from the impulses r (nc, d), free of the drift of step-by-step updates."""
    x[:] = form.rest
    for i in range(len(r)):
        for k in range(form.push_start[i], form.push_start[i + 1]):
            pushed = 0.0
            for j in range(r.shape[1]):
                pushed += form.push[k, j] * r[i, j]
            x[form.push_column[k]] += pushed


@njit(cache=True)
def velocity(form, x, u):  # type: ignore[no-untyped-def]
    """u (nc, d), the contact velocities of state x."""
    u[:] = form.offset
    for i in range(len(u)):
        for k in range(form.read_start[i], form.read_start[i + 1]):
            for j in range(u.shape[1]):
                u[i, j] += form.read[k, j] * x[form.read_column[k]]
