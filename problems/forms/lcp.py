"""The linear complementarity problem, and the friction problem written as one.

    LCP(M, q):   find z >= 0 with  w = M z + q >= 0  and  z'w = 0.

One time step with Coulomb's law on a polygonal cone (Stewart and Trinkle 1996; Anitescu and Potra 1997) is the LCP in
z = (c, beta, lambda): normal impulses c (nc), impulses beta (nc*K) along K balanced tangent directions per contact, and
the sliding speeds lambda (nc),

    M = [ N'PN  N'PD  0 ]        q = (N'v* + b, D'v*, b_f)
        [ D'PN  D'PD  E ]
        [  U    -E'   0 ]

with P the inverse mass on the joints' null space, U = diag(mu), E = blkdiag(1_K). In the plane K = 2 and D = (t, -t), and
the polygon is Coulomb's cone itself.
"""

from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse

from problems import check
from problems.check import Array
from problems.forms.delassus import apply

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LCP:
    """Find z >= 0 with w = M z + q >= 0 and z'w = 0.

    M: (n, n), dense or sparse; kept sparse. q: (n,).
    generators: (nc*d, n) or None; where the LCP is a friction problem's, generators @ z are its contact impulses.
    contacts: number of contacts nc and dimension d of those impulses, (0, 0) for a bare LCP.
    Errors: InputError naming M or q for a wrong shape, NaN or infinity.
    """

    M: sparse.csr_array
    q: Array
    generators: sparse.csr_array | None = field(default=None, repr=False)
    contacts: tuple[int, int] = (0, 0)

    def __post_init__(self) -> None:
        q = check.vector("q", self.q)
        object.__setattr__(self, "q", q)
        object.__setattr__(self, "M", check.matrix("M", self.M, (len(q), len(q))))

    @property
    def size(self) -> int:
        return len(self.q)

    @cached_property
    def dense(self) -> Array:
        """M as a read-only dense (n, n) array in C order."""
        dense = np.ascontiguousarray(self.M.toarray())
        dense.setflags(write=False)
        return dense

    def impulse(self, z: Array) -> Array:
        """The contact impulses (nc, d), normal first, of a friction LCP's z; (0, 0) for a bare LCP."""
        if self.generators is None:
            return np.zeros((0, 0))
        return apply(self.generators, check.entries("z", z, self.size)).reshape(self.contacts)

    def residual(self, z: Array) -> float:
        """max_i |min(z_i, w_i)| over max|q| (over 1 where q = 0): zero exactly at a solution, NaN counts as infinity."""
        z = check.entries("z", z, self.size)
        if not self.size:
            return 0.0
        worst = np.abs(np.minimum(z, self.M @ z + self.q)).max()
        scale = np.abs(self.q).max() or 1.0
        return float(worst / scale) if np.isfinite(worst) else np.inf

    @cached_property
    def hash(self) -> str:
        """Content hash: equal for equal M and q, whatever form they came in."""
        return content_hash(M=self.M, q=self.q)


def friction_lcp(W: sparse.csr_array, q: Array, friction: Array, friction_bias: Array, directions: Array) -> LCP:
    """The friction LCP of a Delassus matrix.

    W: (nc*d, nc*d) and q: (nc*d,), rows per contact, normal first. friction, friction_bias: (nc,).
    directions: (d-1, K), balanced unit tangent directions; [[1, -1]] in the plane.
    """
    nc, (tangents, K) = len(friction), directions.shape
    d, n = tangents + 1, nc * (K + 2)
    # A contact's impulse is basis @ (c, beta): its row is where c goes, then the directions.
    basis = np.zeros((d, 1 + K))
    basis[0, 0] = 1.0
    basis[1:, 1:] = directions
    M = sparse.csr_array(_friction_rows(nc, W.indptr, W.indices, W.data, friction, basis), shape=(n, n))
    M.eliminate_zeros()
    contact, row, column = (part.ravel() for part in np.meshgrid(np.arange(nc), np.arange(d), np.arange(1 + K), indexing="ij"))
    place = np.where(column == 0, contact, nc + contact * K + column - 1)
    H = sparse.csr_array((basis[row, column], place, np.arange(nc * d + 1) * (1 + K)), shape=(nc * d, n))
    along = (q.reshape(nc, d) @ basis) if nc else np.zeros((0, 1 + K))
    return LCP(M, np.concatenate([along[:, 0], along[:, 1:].ravel(), friction_bias]), H, (nc, d))


@njit(cache=True)
def _along(block: Array, basis: Array, a: int, b: int) -> float:
    """basis[:, a]' block basis[:, b]."""
    total = 0.0
    for s in range(len(block)):
        for t in range(len(block)):
            total += basis[s, a] * block[s, t] * basis[t, b]
    return total


@njit(cache=True)
def _friction_rows(
    nc: int, indptr: Index, indices: Index, data: Array, friction: Array, basis: Array
) -> tuple[Array, Index, Index]:
    """The friction LCP's matrix in CSR form (data, indices, indptr), columns sorted, zeros stored."""
    d, width = basis.shape
    K = width - 1
    # The contacts that each contact touches through a body, in order, from the rows of W.
    first = np.zeros(nc + 1, dtype=np.int64)
    beside = np.empty(len(indices), dtype=np.int64)
    block = np.zeros((len(indices), d, d))
    place = np.full(nc, -1, dtype=np.int64)
    for i in range(nc):
        count = first[i]
        for a in range(d):
            for k in range(indptr[i * d + a], indptr[i * d + a + 1]):
                j = indices[k] // d
                if place[j] < first[i]:
                    place[j] = count
                    beside[count] = j
                    count += 1
        first[i + 1] = count
        beside[first[i] : count].sort()
        for k in range(first[i], count):
            place[beside[k]] = k
        for a in range(d):
            for k in range(indptr[i * d + a], indptr[i * d + a + 1]):
                block[place[indices[k] // d], a, indices[k] % d] = data[k]
    entries = first[nc] * width * width + nc * (2 * K + 1)
    M_data = np.empty(entries)
    M_indices = np.empty(entries, dtype=np.int64)
    M_indptr = np.empty(nc * (K + 2) + 1, dtype=np.int64)
    M_indptr[0] = at = 0
    for row in range(nc * width):
        i, a = (row, 0) if row < nc else ((row - nc) // K, 1 + (row - nc) % K)
        for k in range(first[i], first[i + 1]):
            M_indices[at] = beside[k]
            M_data[at] = _along(block[k], basis, a, 0)
            at += 1
        for k in range(first[i], first[i + 1]):
            for m in range(K):
                M_indices[at] = nc + beside[k] * K + m
                M_data[at] = _along(block[k], basis, a, 1 + m)
                at += 1
        if a:
            M_indices[at], M_data[at] = nc * width + i, 1.0
            at += 1
        M_indptr[row + 1] = at
    for i in range(nc):
        M_indices[at], M_data[at] = i, friction[i]
        M_indices[at + 1 : at + 1 + K] = nc + i * K + np.arange(K)
        M_data[at + 1 : at + 1 + K] = -1.0
        at += 1 + K
        M_indptr[nc * width + i + 1] = at
    return M_data[:at], M_indices[:at], M_indptr


def content_hash(**fields: Any) -> str:
    """sha256 of named arrays, sparse or dense, and plain values, in the order given."""
    digest = sha256()
    for name, value in fields.items():
        if sparse.issparse(value):
            rows = sparse.csr_array(value)
            parts = [np.array(rows.shape), rows.indptr.astype(np.int64), rows.indices.astype(np.int64), rows.data + 0.0]
        else:
            array = np.asarray(value)
            parts = [np.array(array.shape), array + 0.0 if array.dtype.kind == "f" else array]
        digest.update(name.encode())
        for part in parts:
            digest.update(part.dtype.str.encode() + np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()[:16]
