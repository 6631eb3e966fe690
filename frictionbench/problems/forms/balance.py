"""The parts of a problem, which nothing connects, each in a unit of velocity of its own.

A friction problem is homogeneous: free velocities, biases and friction biases divided by a factor > 0 give impulses divided by
it. Separate parts may have factors of their own, so that one which is slow is solved like one which is fast. The factors are
powers of two, which change no digits: the largest unit of a part over the largest of the problem, rounded.

A part is a number from 0, of a node that no contact is connected with -1. These are kernels because every solve takes them.
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.islands import top


@kernel
def mechanical_parts(start, column, m_start, m_column, f_start, f_column):  # type: ignore[no-untyped-def]
    """Parts (nc+nv+nj,) of contacts, velocities and joint equations, from the patterns of J by contacts, of M and F by rows."""
    nc, nv, nj = len(start) - 1, len(m_start) - 1, len(f_start) - 1
    parent = np.arange(nc + nv + nj)
    _connect(parent, 0, start, column, nc)
    _connect(parent, nc, m_start, m_column, nc)
    _connect(parent, nc + nv, f_start, f_column, nc)
    return _numbered(parent, nc)


@kernel
def delassus_parts(first, neighbours):  # type: ignore[no-untyped-def]
    """The parts (nc,) of the contacts, from the pattern of W by blocks."""
    parent = np.arange(len(first) - 1)
    _connect(parent, 0, first, neighbours, 0)
    return _numbered(parent, len(parent))


@part
def _connect(parent, begin, start, column, offset):  # type: ignore[no-untyped-def]
    """Join each row of a pattern, from node begin on, with its columns, from node offset on."""
    for i in range(len(start) - 1):
        for k in range(start[i], start[i + 1]):
            parent[top(parent, begin + i)] = top(parent, offset + column[k])


@part
def _numbered(parent, nc):  # type: ignore[no-untyped-def]
    number, found, count = np.full(len(parent), -1), np.empty(len(parent), np.int64), 0
    for i in range(len(parent)):
        root = top(parent, i)
        if i < nc and number[root] < 0:
            number[root] = count
            count += 1
        found[i] = number[root]
    return found


@kernel
def factors(parts, units):  # type: ignore[no-untyped-def]
    """The factor of each node (nodes,), of the units (nc,) of the contacts; 1 for what no contact is connected with."""
    fastest, own, factor = 0.0, np.zeros(len(parts)), np.ones(len(parts))
    for i in range(len(units)):
        fastest = max(fastest, units[i])
        own[parts[i]] = max(own[parts[i]], units[i])
    for v in range(len(parts)):
        if parts[v] >= 0 and own[parts[v]] > 0:
            factor[v] = 2.0 ** np.rint(np.log2(own[parts[v]] / fastest))
    return factor
