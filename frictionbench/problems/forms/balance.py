"""The parts of a problem, which nothing connects, each in a unit of velocity of its own.

A friction problem is homogeneous: free velocities, biases and friction biases divided by a factor > 0 give impulses divided by
it. Separate parts may have factors of their own, so that one which is slow is solved like one which is fast. The factors are
powers of two, which change no digits: the largest unit of a part over the largest of the problem, rounded.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.rows import Array, Index64


def components(row: Index64, column: Index64, nodes: int, contacts: int) -> Index64:
    """The component (nodes,) of each node, those of the first nodes, the contacts, numbered from 0, all others -1.

    row, column: the nodes that are connected.
    """
    graph = sparse.coo_array((np.ones(len(row)), (row, column)), shape=(nodes, nodes))
    count, component = connected_components(graph, directed=False)
    number = np.full(count, -1)
    touched = np.unique(component[:contacts])
    number[touched] = np.arange(len(touched))
    return np.asarray(number[component])


def factors(part: Index64, units: Array) -> Array:
    """The factor of each node (nodes,), of the units (nc,) of the contacts; 1 for what no contact is connected with."""
    own = np.zeros(part.max(initial=-1) + 2)  # the last of the parts without contacts, -1
    np.maximum.at(own, part[: len(units)], units)
    share = own / (own.max() or 1.0)
    return np.asarray(2.0 ** np.rint(np.log2(share, out=np.zeros_like(share), where=share > 0)))[part]
