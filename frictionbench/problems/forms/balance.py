"""Islands without any coupling, each in a unit of velocity of its own.

A friction problem is homogeneous: free velocities, biases and friction biases divided by a factor > 0 give impulses divided by
it. Separate islands may have factors of their own, so that one which is slow is solved like one which is fast. The factors are
powers of two, which change no digits: the largest unit of an island over the largest of the problem, rounded.
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.islands import top


@kernel
def mechanical_factors(start, column, m_start, m_column, f_start, f_column, units):  # type: ignore[no-untyped-def]
    """The factors of the contacts (nc,) and of the velocities (nv,), from the patterns of J by contacts, M and F by rows."""
    nc, nv = len(start) - 1, len(m_start) - 1
    parent = np.arange(nc + nv)
    for i in range(nc):
        for k in range(start[i], start[i + 1]):
            parent[top(parent, i)] = top(parent, nc + column[k])
    for v in range(nv):
        for m in range(m_start[v], m_start[v + 1]):
            parent[top(parent, nc + v)] = top(parent, nc + m_column[m])
    for j in range(len(f_start) - 1):
        for k in range(f_start[j] + 1, f_start[j + 1]):
            parent[top(parent, nc + f_column[k])] = top(parent, nc + f_column[k - 1])
    factor = _factors(parent, units)
    return factor[:nc], factor[nc:]


@kernel
def delassus_factors(first, neighbours, units):  # type: ignore[no-untyped-def]
    """The factors of the contacts (nc,), from the pattern of W by blocks."""
    parent = np.arange(len(units))
    for i in range(len(units)):
        for k in range(first[i], first[i + 1]):
            parent[top(parent, i)] = top(parent, np.int64(neighbours[k]))
    return _factors(parent, units)


@part
def _factors(parent, units):  # type: ignore[no-untyped-def]
    """The factor of each node of a forest whose first nodes are the contacts; 1 for those without contacts."""
    fastest, own, factor = 0.0, np.zeros(len(parent)), np.ones(len(parent))
    for i in range(len(units)):
        fastest, island = max(fastest, units[i]), top(parent, i)
        own[island] = max(own[island], units[i])
    for v in range(len(parent)):
        unit = own[top(parent, v)]
        if unit > 0:
            factor[v] = 2.0 ** np.rint(np.log2(unit / fastest))
    return factor
