"""The unconnected parts of a problem, and factors that scale each part to its own unit of velocity.

A friction problem is homogeneous: if free velocities, biases and friction biases are divided by a factor > 0, so are impulses.
Each part may have its own factor, so that slow parts are solved as accurately as fast ones. A factor is the largest unit of a
part divided by the largest of the problem, rounded to a power of two, so that scaling is exact.

Parts are numbered from 0; nodes without a connection to any contact have -1. Kernels are used because every solve needs them.
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.islands import numbered, top


@kernel
def mechanical_parts(start, column, m_start, m_column, f_start, f_column):  # type: ignore[no-untyped-def]
    """Parts (nc+nv+nj,) of contacts, velocities and joint equations, from the sparsity patterns of J, M and F."""
    nc, nv, nj = len(start) - 1, len(m_start) - 1, len(f_start) - 1
    parent = np.arange(nc + nv + nj)
    _connect(parent, 0, start, column, nc)
    _connect(parent, nc, m_start, m_column, nc)
    _connect(parent, nc + nv, f_start, f_column, nc)
    return numbered(parent, nc)


@kernel
def delassus_parts(first, neighbours):  # type: ignore[no-untyped-def]
    """Parts (nc,) of the contacts, from the sparsity pattern of W by blocks."""
    parent = np.arange(len(first) - 1)
    _connect(parent, 0, first, neighbours, 0)
    return numbered(parent, len(parent))


@part
def _connect(parent, begin, start, column, offset):  # type: ignore[no-untyped-def]
    """Connect each row of a sparsity pattern (node begin + row) with its columns (node offset + column)."""
    for i in range(len(start) - 1):
        for k in range(start[i], start[i + 1]):
            parent[top(parent, begin + i)] = top(parent, offset + column[k])


@kernel
def factors(parts, units):  # type: ignore[no-untyped-def]
    """The factor of each node (nodes,) for the contacts' units (nc,); 1 for nodes without a connection to any contact."""
    fastest, largest, factor = 0.0, np.zeros(len(parts)), np.ones(len(parts))
    for i in range(len(units)):
        fastest = max(fastest, units[i])
        largest[parts[i]] = max(largest[parts[i]], units[i])
    for v in range(len(parts)):
        if parts[v] >= 0 and largest[parts[v]] > 0:
            factor[v] = 2.0 ** np.rint(np.log2(largest[parts[v]] / fastest))
    return factor
