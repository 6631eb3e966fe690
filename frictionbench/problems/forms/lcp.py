"""The linear complementarity problem, and the friction problem written as one.

    LCP(M, q):   find z >= 0 with  w = M z + q >= 0  and  z'w = 0.

One time step with Coulomb's law on a polygonal cone (Stewart and Trinkle 1996; Anitescu and Potra 1997) is the LCP in
z = (c, beta, lambda): normal impulses c (nc), impulses beta (nc*K) along K balanced tangent directions per contact, and
the sliding speeds lambda (nc),

    M = [ N'PN  N'PD  0 ]        q = (N'v* + b, D'v*, b_f)
        [ D'PN  D'PD  E ]
        [  U    -E'   0 ]

where P is the inverse mass on the joints' null space, U = diag(mu) and E = blkdiag(1_K). In the plane K = 2 and D = (t, -t),
and the polygonal cone is Coulomb's cone itself.
"""

from functools import cache, cached_property
from hashlib import sha256
from typing import Any, Self

import numpy as np
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array, ReadOnly, counted
from frictionbench.problems.compiled import kernel, lean
from frictionbench.problems.forms.delassus import LOCKED
from frictionbench.problems.rows import Rows


class LCP(ReadOnly):
    """Find z >= 0 with w = M z + q >= 0 and z'w = 0.

    M: (n, n), dense or sparse; stored as plain sparse arrays in `rows`, of which M is a view as a SciPy matrix. q: (n,).
    contacts: number of contacts nc and dimension d, (0, 0) for a bare LCP. basis: (d, 1 + K) or None; a contact's impulse is
    basis @ (c, beta).
    Errors: InputError naming M or q for a wrong shape, NaN or infinity.

    >>> import frictionbench as fb
    >>> lcp = fb.LCP([[2.0, 1.0], [1.0, 2.0]], [-3.0, -3.0])
    >>> answer = fb.solve(lcp, "lemke")
    >>> lcp.residual(answer.z) < 1e-12, [round(z, 6) for z in answer.z.tolist()]
    (True, [1.0, 1.0])
    """

    rows: Rows
    q: Array
    basis: Array | None = None
    contacts: tuple[int, int] = (0, 0)

    def __init__(self, M: Any, q: Any) -> None:
        self.q = check.vector("q", q)
        self.rows = check.rows("M", M, (len(self.q), len(self.q)))

    @classmethod
    def of_friction(cls, rows: Rows, q: Array, basis: Array | None, contacts: tuple[int, int]) -> Self:
        """A friction problem's LCP, or a bare one, from parts that have been checked."""
        lcp = object.__new__(cls)
        lcp.rows, lcp.q, lcp.basis, lcp.contacts = rows, q, basis, contacts
        return lcp

    @property
    def size(self) -> int:
        """The number of unknowns n."""
        return len(self.q)

    @cached_property
    def M(self) -> sparse.csr_array:
        """M (n, n), sparse and read-only."""
        return self.rows.matrix(self.size)

    @cached_property
    def dense(self) -> Array:
        """M as a read-only dense (n, n) array in C order."""
        dense = dense_matrix(*self.rows, self.size)
        dense.setflags(write=False)
        return dense

    def fresh(self) -> "LCP":
        """The same problem without anything derived from it."""
        return LCP.of_friction(self.rows, self.q, self.basis, self.contacts)

    def impulse(self, z: Array) -> Array:
        """The contact impulses (nc, d) in N s, normal first, of a friction LCP's z (n,); shape (0, 0) for a bare LCP.

        Errors: InputError naming z if it does not have n entries.
        """
        if self.basis is None:
            return np.zeros((0, 0))
        return impulse(self.basis, check.entries("z", z, self.size), self.contacts[0])

    def residual(self, z: Array) -> float:
        """max_i |min(z_i, w_i)| / max|q| (not divided if q = 0) for z (n,): zero exactly at a solution, infinity for NaN.

        Errors: InputError naming z if it does not have n entries.
        """
        z = check.entries("z", z, self.size)
        if not self.size:
            return 0.0
        worst = np.abs(np.minimum(z, self.M @ z + self.q)).max()
        scale = np.abs(self.q).max() or 1.0
        return float(worst / scale) if np.isfinite(worst) else np.inf

    @cached_property
    def hash(self) -> str:
        """Content hash: equal for equal M and q, whatever form they were given in."""
        return content_hash(M=self.M, q=self.q)

    @property
    def summary(self) -> str:
        """The size in words, for example: LCP of 36 unknowns."""
        return f"LCP of {counted(self.size, 'unknown')}"

    def __repr__(self) -> str:
        return f"LCP({counted(self.size, 'unknown')})"


@cache
def tangent_basis(dimension: int, facets: int = 8) -> Array:
    """(d, 1 + K): a contact's impulse is basis @ (c, beta): the normal, then K balanced unit tangent directions.

    Errors: InputError naming facets if it is odd or less than 4.
    """
    check.require(facets >= 4 and facets % 2 == 0, "facets", f"must be even and at least 4, got {facets!r}")
    basis = np.zeros((dimension, 3 if dimension == 2 else 1 + facets))
    basis[0, 0] = 1.0
    if dimension == 2:
        basis[1, 1:] = 1.0, -1.0
    else:
        angle = 2 * np.pi * np.arange(facets) / facets
        section = np.array([np.cos(angle), np.sin(angle)])
        basis[1:, 1:] = np.where(np.abs(section) > 1e-15, section, 0.0)  # exact zeros, so that locked directions remain locked
    return basis


def by_unknown(values: Array, unknowns: int) -> Array:
    """The contacts' values (nc,), repeated for the LCP's unknowns (c, beta, lambda), (unknowns,)."""
    return np.concatenate([values, np.repeat(values, unknowns // len(values) - 2), values])


@kernel
def impulse(basis, z, nc):  # type: ignore[no-untyped-def]
    """The contact impulses (nc, d) of a friction LCP's z."""
    r = np.empty((nc, len(basis)))
    write_impulse(basis, z, r)
    return r


@lean
def write_impulse(basis, z, r):  # type: ignore[no-untyped-def]
    """Write `impulse` to r (nc, d)."""
    nc, (d, width) = len(r), basis.shape
    for i in range(nc):
        for a in range(d):
            r[i, a] = basis[a, 0] * z[i]
            for m in range(1, width):
                r[i, a] += basis[a, m] * z[nc + i * (width - 1) + m - 1]


@lean
def contact_of(j, n, nc):  # type: ignore[no-untyped-def]
    """The contact to which unknown j of the n unknowns (c, beta, lambda) belongs."""
    return j if j < nc else j - (n - nc) if j >= n - nc else (j - nc) // ((n - 2 * nc) // nc)


@kernel
def dense_matrix(start, column, value, n):  # type: ignore[no-untyped-def]
    """A square matrix by rows as a dense array."""
    dense = np.zeros((n, n))
    for i in range(n):
        for k in range(start[i], start[i + 1]):
            dense[i, column[k]] = value[k]
    return dense


@kernel
def friction_rows(first, neighbours, block, q, friction, friction_bias, basis):  # type: ignore[no-untyped-def]
    """The friction LCP's matrix by rows, without zeros, and its right-hand side q.

    first, neighbours, block: W by blocks (problems.forms.delassus). q: (nc*d,), normal first. friction, friction_bias: (nc,).
    basis: (d, 1 + K), see tangent_basis.
    """
    nc, (d, width) = len(friction), basis.shape
    K = width - 1
    n, entries = nc * (width + 1), len(neighbours) * width * width + nc * (2 * K + 1)
    start, column, value, right = np.empty(n + 1, np.int32), np.empty(entries, np.int32), np.empty(entries), np.zeros(n)
    part = np.empty((len(block), width, width))
    write_in_basis(block, len(block), basis, part)
    start[0] = at = row = 0
    for tangential in range(2):  # the normal rows of all contacts, then the tangential rows contact by contact
        for i in range(nc):
            for b in range(1, width) if tangential else range(1):
                for a in range(d):
                    right[row] += basis[a, b] * q[i * d + a]
                for k in range(first[i], first[i + 1]):
                    column[at], value[at] = neighbours[k], part[k, b, 0]
                    at += part[k, b, 0] != 0
                for k in range(first[i], first[i + 1]):
                    for m in range(K):
                        column[at], value[at] = nc + neighbours[k] * K + m, part[k, b, 1 + m]
                        at += part[k, b, 1 + m] != 0
                if b:
                    column[at], value[at] = nc * width + i, 1.0
                    at += 1
                row += 1
                start[row] = at
    for i in range(nc):
        column[at], value[at] = i, friction[i]
        at += friction[i] != 0
        for m in range(K):
            column[at], value[at] = nc + i * K + m, -1.0
            at += 1
        start[row + i + 1], right[row + i] = at, friction_bias[i]
    return start, column[:at], value[:at], right


@lean
def write_in_basis(block, entries, basis, part):  # type: ignore[no-untyped-def]
    """Write basis' B basis for the first `entries` blocks B to part (entries, width, width). Diagonal entries that are rounding
    errors, in directions that joints lock, are set to 0."""
    d, width = basis.shape
    for k in range(entries):
        if d == 2:  # as below, unrolled: t and -t
            part[k, 0, 0], part[k, 0, 1], part[k, 0, 2] = block[k, 0, 0], block[k, 0, 1], -block[k, 0, 1]
            part[k, 1, 0], part[k, 1, 1], part[k, 1, 2] = block[k, 1, 0], block[k, 1, 1], -block[k, 1, 1]
            part[k, 2, 0], part[k, 2, 1], part[k, 2, 2] = -block[k, 1, 0], -block[k, 1, 1], block[k, 1, 1]
            continue
        for a in range(width):
            for b in range(width):
                part[k, a, b] = 0.0
        for s in range(d):
            for t in range(d):
                for a in range(width):
                    if basis[s, a] != 0:
                        for b in range(width):
                            part[k, a, b] += basis[s, a] * block[k, s, t] * basis[t, b]
        trace = 0.0
        for s in range(d):
            trace += abs(block[k, s, s])
        for a in range(width):
            if abs(part[k, a, a]) <= LOCKED * trace:
                part[k, a, a] = 0.0


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
        for piece in parts:
            digest.update(piece.dtype.str.encode() + np.ascontiguousarray(piece).tobytes())
    return digest.hexdigest()[:16]
