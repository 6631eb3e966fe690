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
from scipy import sparse

from problems import check
from problems.check import Array


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
        return np.asarray(self.generators @ z).reshape(self.contacts)

    def residual(self, z: Array) -> float:
        """max_i |min(z_i, w_i)| over max|q| (over 1 where q = 0): zero exactly at a solution, NaN counts as infinity."""
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
    d = tangents + 1
    eye = sparse.eye_array(nc)
    e_n = np.zeros((d, 1))
    e_n[0] = 1
    normal = sparse.kron(eye, e_n)
    tangent = sparse.kron(eye, np.vstack([np.zeros((1, K)), directions]))
    H = sparse.csr_array(sparse.hstack([normal, tangent]))
    E = sparse.kron(eye, np.ones((K, 1)))
    cone = sparse.hstack([sparse.diags_array(friction), -E.T])
    slack = sparse.vstack([sparse.csr_array((nc, nc)), E])
    M = sparse.block_array([[H.T @ W @ H, slack], [cone, None]], format="csr")
    padded = sparse.csr_array(sparse.hstack([H, sparse.csr_array((nc * d, nc))]))
    return LCP(M, np.concatenate([H.T @ q, friction_bias]), padded, (nc, d))


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
