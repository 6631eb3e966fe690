"""The scaled LCP of a packed problem, for the loops of the pivoting methods, and the way back to impulses."""

from frictionbench.problems.compiled import inlined, lean
from frictionbench.problems.forms.lcp import write_impulse
from frictionbench.problems.packed import Q, blocks_of, law_of
from frictionbench.solvers.pivots.inverse_basis import Matrix
from frictionbench.solvers.pivots.scaled_lcp import scaled_friction_lcp


@inlined
def scaled_lcp_of(packed, k, basis):  # type: ignore[no-untyped-def]
    """Problem k's scaled LCP: stretch, M, q and unit as in ScaledLCP."""
    first, neighbours, block = blocks_of(packed, k)
    mu, wider, scale, units = law_of(packed, k)
    q = packed.q[packed.first[k, Q] : packed.first[k + 1, Q]]
    start, rows, column, row, stretch, right, unit = scaled_friction_lcp(
        first, neighbours, block, q, mu, wider, basis, scale, units
    )
    return stretch, Matrix(start, rows, column, row), right, unit


@lean
def write_stretched(basis, y, stretch, r):  # type: ignore[no-untyped-def]
    """Write the impulses of z = stretch * y over r (nc, d); y is overwritten by z."""
    for i in range(len(y)):
        y[i] *= stretch[i]
    write_impulse(basis, y, r)
