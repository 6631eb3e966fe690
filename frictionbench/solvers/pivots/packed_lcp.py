"""The scaled LCP of a packed problem, for the loops of the pivoting methods, and the way back to impulses."""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, kernel, lean
from frictionbench.problems.forms.delassus import places_of_delassus, write_delassus, write_partners
from frictionbench.problems.forms.lcp import write_impulse, write_in_basis
from frictionbench.problems.packed import BLOCK, COLUMN, VELOCITY, Packed, Q, known_blocks, law_of, mechanical, mechanics_of
from frictionbench.problems.rows import Index32
from frictionbench.solvers.pivots.inverse_basis import Matrix
from frictionbench.solvers.pivots.scaled_lcp import most_entries, write_scaled_lcp

FULL, NEIGHBOURS = 64, 64  # there is storage for FULL + NEIGHBOURS blocks of W a contact, on average


class LCPSpace(NamedTuple):
    """Workspace for the LCP of any one of the packed problems; see write_delassus, write_in_basis and write_scaled_lcp."""

    places: Index32
    response: Array
    first: Index32
    neighbours: Index32
    block: Array
    part: Array
    partner: Index32
    matrix: Matrix
    stretch: Array
    right: Array
    unit: Array


def lcp_space(packed: Packed, basis: Array) -> LCPSpace:
    """Workspace for the LCPs of packed problems."""
    nc, nv, touched, blocks = (
        int(np.diff(first).max(initial=0)) for first in (packed.contacts, *packed.first[:, [VELOCITY, COLUMN, BLOCK]].T)
    )
    return _lcp_space(nc, nv, touched, max(blocks, nc * min(nc, FULL + NEIGHBOURS)), *basis.shape)


@kernel
def _lcp_space(nc, nv, touched, blocks, d, width):  # type: ignore[no-untyped-def]
    n, entries, index = nc * (width + 1), most_entries(blocks, nc, width), np.int32
    return LCPSpace(
        np.empty(places_of_delassus(nc, nv, touched), index),
        np.empty((nv, d)),
        np.empty(nc + 1, index),
        np.empty(blocks, index),
        np.empty((blocks, d, d)),
        np.empty((blocks, width, width)),
        np.empty(blocks, index),
        Matrix(np.empty(n + 1, np.int64), np.empty(entries, np.uint32), np.empty(entries), np.empty(entries)),
        np.empty(n),
        np.empty(n),
        np.empty(2 * n),
    )


@inlined
def scaled_lcp_of(packed, k, basis, space):  # type: ignore[no-untyped-def]
    """Form problem k's scaled LCP in `space`; whether it fits, and its stretch, M, q and unit as in ScaledLCP."""
    mu, wider, scale, units = law_of(packed, k)
    nc, width, q = len(mu), basis.shape[1], packed.q[packed.first[k, Q] : packed.first[k + 1, Q]]
    n, fits = nc * (width + 1), True
    first, neighbours, block = space.first[: nc + 1], space.neighbours, space.block
    if mechanical(packed, k):
        start, column, J, m_start, m_column, m_value, _, _ = mechanics_of(packed, k)
        moving = start, column, J, m_start, m_column, m_value
        fits = write_delassus(*moving, space.places, space.response, first, neighbours, block)
    else:
        first, neighbours, block = known_blocks(packed, k)
    stretch, M, right, unit = space.stretch[:n], space.matrix, space.right[:n], space.unit[: 2 * n].reshape(2, n)
    if fits:
        write_partners(first, neighbours, space.partner, space.places)
        write_in_basis(block, first[nc], basis, space.part)
        parts = first, neighbours, space.part, space.partner, q, mu, wider, basis, scale, units
        write_scaled_lcp(*parts, M.start, M.rows, M.column, M.row, stretch, right, unit)
    return fits, stretch, M, right, unit


@lean
def write_stretched(basis, y, stretch, r):  # type: ignore[no-untyped-def]
    """Overwrite r (nc, d) with the impulses of z = stretch * y, and y with z."""
    for i in range(len(y)):
        y[i] *= stretch[i]
    write_impulse(basis, y, r)
