"""The islands of a problem, and the velocity in which the residual of each contact is measured.

Two contacts are coupled if an impulse at one changes the velocity of the other. The impulse that stops contact j's own velocity
|q_j| changes that of contact i by a share |W_ij| / s_j of it. Shares below COUPLED are ignored, so that bodies that rest on one
very heavy body are separate. An *island* is a connected component of this graph. A contact's *demand* is the least change of
its velocity that impulses must cause,

    c_i = max(-q_n,i, 0),      with a friction bias at least min(|q_t,i|, s_i b_f,i).

The *unit* (m/s) of an island's contacts is the largest demand in it, so that the residual of zero impulses is 1. If no demand
in an island exceeds rounding, zero impulses are a solution, and the unit is the largest speed |q_i|. A contact's velocity is a
sum of terms J v* and b, known only to rounding. A unit is therefore at least CANCELLED times the largest terms in the island,
CANCELLED times the contact's own terms, and NOISE times the problem's largest unit. If nothing in an island moves, its unit is
the largest of the problem.

Rows of joints, that is limits without a tangent or dry friction without a normal, may be in rad/s beside contacts in m/s. The b
of a row without a normal only keeps it open; it is not a velocity, and units do not depend on it. Velocities of rows and of
other contacts are compared as |q_j| / sqrt(s_j), the root of an energy. The unit of a contact i is the largest of all c_j of
contacts and all sqrt(s_i / s_j) c_j of rows in its island; the unit of a row i is the largest of all sqrt(s_i / s_j) c_j.

A contact that opens, q_n,i > 0, carries load only if others push it. Coulomb's law implies r'u <= 0, hence r'Wr <= -r'q: the
energy of the impulses is at most that of the motion they stop, and they change contact i's velocity by at most sqrt(s_i) times
its root. With

    E_i = sum_j |q_j|^2 / s_j      over the contacts j of its island that close, q_n,j <= 0 to rounding,

its speed counts as at most FAR sqrt(s_i E_i), however fast it slides, or as CANCELLED times its terms. If q_n,i exceeds
FAR sqrt(s_i E_i), it is open in every answer, r_n,i = 0, and couples no other contacts, unless it has a friction bias. Its unit
is then the smallest of the islands that push it, or its own speed if there are none; its defect s r_n has no rounding errors of
u_n. A contact with a friction bias enters the sum with the sliding that b_f can stop. E_i estimates the energy and is invariant
under changes of frame, of units and of the observer's velocity.

If the mechanics are given, W is not formed: a contact acts on the velocities that it touches, with
|W_ij| <= sum_v |J_iv| |J_jv| / m_v, and bodies coupled by the mass matrix or joints count as one.
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part

EPSILON = float(np.finfo(float).eps)  # from 1 to the next double: twice the largest relative error of one rounding
COUPLED = 1e-10  # share of a velocity that is transmitted: islands stay connected for mass ratios of neighbours up to 1e10
FAR = 10.0  # E_i is less than the energy if contacts share bodies: for equal masses, by the root of their number
CANCELLED = 1e-6  # so that the rounding floor of contacts at rest on moving bodies is about 1e-9
NOISE = 1e-14  # about 50 roundings: relative to a contact's speed, to decide if it opens, and to the terms of a demand


@kernel
def mechanical_units(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, f_start, f_column, moves, bias, q, s, b_f
):
    """The units (nc,) of a mechanical problem, and the island (nc,) of each contact.

    moves: (nv,), the size of the terms of each velocity. f_start, f_column: the sparsity pattern of F by rows.
    """
    nc, d = len(s), J.shape[1]
    size, closes, row, q, flat = np.empty(nc), np.empty(nc, np.bool_), np.empty(nc, np.bool_), q.copy(), J.reshape(-1)
    for i in range(nc):
        normal, tangent, of_normal, terms = 0.0, 0.0, abs(bias[i]), 0.0
        for k in range(start[i], start[i + 1]):
            normal, tangent = max(normal, abs(J[k, 0])), max(tangent, length(flat, k * d + 1, d - 1))
            of_normal += abs(J[k, 0]) * moves[column[k]]
            terms += length(flat, k * d, d) * moves[column[k]]
        row[i] = normal == 0 or tangent == 0
        if normal == 0:
            open_without_normal(q, i, d)
        else:
            terms += abs(bias[i])
        size[i] = max(terms, own_speed(q, i, d))
        closes[i] = q[i * d] <= max(CANCELLED * of_normal, NOISE * own_speed(q, i, d))
    graph = mechanical_graph(start, column, J, m_start, m_column, m_value, f_start, f_column, s)
    return _units(*graph, size, closes, row, q, s, b_f)


@kernel
def delassus_units(first, neighbours, block, q, s, b_f):  # type: ignore[no-untyped-def]
    """`mechanical_units` for a problem of which only W, by blocks, and q are known."""
    nc, d = len(s), block.shape[1]
    size, closes, row, q = np.empty(nc), np.empty(nc, np.bool_), np.zeros(nc, np.bool_), q.copy()
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            if neighbours[k] == i:
                tangent = 0.0
                for a in range(1, d):
                    tangent += block[k, a, a]
                row[i] = block[k, 0, 0] <= 0 or tangent <= 0
                if block[k, 0, 0] <= 0:
                    open_without_normal(q, i, d)
        size[i] = own_speed(q, i, d)
        closes[i] = q[i * d] <= NOISE * size[i]
    return _units(*delassus_graph(first, neighbours, block, s), size, closes, row, q, s, b_f)


@kernel
def lowered(q, mu):  # type: ignore[no-untyped-def]
    """q (nc*d,) with q_n - mu |q_t| for q_n: what the impulses of the convex relaxation have to lift."""
    lower, d = q.copy(), len(q) // max(len(mu), 1)
    for i in range(len(mu)):
        lower[i * d] -= mu[i] * length(q, i * d + 1, d - 1)
    return lower


@part
def open_without_normal(q, i, d):  # type: ignore[no-untyped-def]
    """Set q_n,i = inf for a row without a normal, so that it is open and its b, which is not a velocity, has no effect."""
    if q[i * d] >= 0:
        q[i * d] = np.inf


@part
def own_speed(q, i, d):  # type: ignore[no-untyped-def]
    """|q_i|, or |q_t,i| for a row without a normal."""
    return length(q, i * d, d) if q[i * d] < np.inf else length(q, i * d + 1, d - 1)


@part
def demand(q, i, d, s, b_f):  # type: ignore[no-untyped-def]
    """c_i, the least change of contact i's velocity that impulses must cause."""
    needed = max(-q[i * d], 0.0)
    return max(needed, min(length(q, i * d + 1, d - 1), s * b_f)) if b_f > 0 else needed


@kernel
def mechanical_graph(start, column, J, m_start, m_column, m_value, f_start, f_column, s):  # type: ignore[no-untyped-def]
    """The graph start, node, push, read, in which contact i has the nodes node[start[i]:start[i+1]]; and the number of nodes.

    Nodes are velocities, scaled so that their kinetic energy is v^2/2. Velocities coupled by the mass matrix or joints share a
    node. push: a node's velocity per own velocity of the contact. read: the contact's velocity per velocity of the node.
    """
    nv = len(m_start) - 1
    root, parent = np.empty(nv), np.empty(nv, np.int64)
    for v in range(nv):
        parent[v] = v
    for v in range(nv):
        m = m_start[v]  # M^-1 has dense blocks (problems.forms.mass), whose rows all have this first column
        parent[top(parent, v)] = top(parent, m_column[m])
        while m_column[m] != v:
            m += 1
        root[v] = np.sqrt(m_value[m])
    for j in range(len(f_start) - 1):
        for k in range(f_start[j] + 1, f_start[j + 1]):
            parent[top(parent, f_column[k])] = top(parent, f_column[k - 1])
    node, push, read = np.empty(len(column), np.int64), np.empty(len(column)), np.empty(len(column))
    for i in range(len(s)):
        for k in range(start[i], start[i + 1]):
            size = 0.0
            for a in range(J.shape[1]):
                size += J[k, a] * J[k, a]
            node[k], read[k] = top(parent, column[k]), np.sqrt(size) * root[column[k]]
            push[k] = read[k] / s[i]
    return start, node, push, read, nv


@kernel
def delassus_graph(first, neighbours, block, s):  # type: ignore[no-untyped-def]
    """`mechanical_graph` for a problem of which only W is known; the nodes are the contacts."""
    node, push, read = np.empty(len(neighbours), np.int64), np.empty(len(neighbours)), np.zeros(len(neighbours))
    for i in range(len(s)):
        for k in range(first[i], first[i + 1]):
            size = 0.0
            for a in range(block.shape[1]):
                for b in range(block.shape[1]):
                    size += block[k, a, b] * block[k, a, b]
            node[k], push[k], read[k] = neighbours[k], np.sqrt(size) / s[i], 1.0 if neighbours[k] == i else 0.0
    return first, node, push, read, len(s)


@part
def _units(start, node, push, read, nodes, size, closes, row, q, s, b_f):  # type: ignore[no-untyped-def]
    """The units and the islands. size: that of the terms of q_i, at least |q_i|. closes: whether q_n,i <= 0 to rounding. row:
    whether a contact is a row of a joint."""
    nc, d = len(s), len(q) // max(len(s), 1)
    needed, speed, terms = np.empty(nc), np.empty(nc), size.copy()
    for i in range(nc):
        needed[i] = demand(q, i, d, s[i], b_f[i])
        speed[i] = max(CANCELLED * size[i], own_speed(q, i, d))
    bears = _bearing(start, node, push, read, nodes, closes, q, s, b_f, needed, speed, terms)
    parent = _components(start, node, push, read, nodes, bears)
    # For each tree, the largest demand, speed and terms: [0] of contacts, [1] of rows over sqrt(s), [2] of all over sqrt(s).
    worst = np.zeros((nc + nodes, 3, 3))
    for i in range(nc):
        if bears[i]:
            tree, root = top(parent, i), np.sqrt(s[i])
            for m, value in enumerate((needed[i], speed[i], terms[i])):
                kind = 1 if row[i] else 0
                worst[tree, m, kind] = max(worst[tree, m, kind], value / root if row[i] else value)
                worst[tree, m, 2] = max(worst[tree, m, 2], value / root)
    unit, island, largest = np.zeros(nc), np.empty(nc, np.int64), 0.0
    for i in range(nc):
        island[i] = top(parent, i)
        if bears[i]:
            unit[i] = _unit(worst, top(parent, i), row[i], s[i])
            largest = max(largest, unit[i])
    if not bears.all():
        first, reader = _readers(start, node, read, nodes)
        for j in range(nc):
            for k in range(start[j], start[j + 1] if bears[j] else start[j]):
                for m in range(first[node[k]], first[node[k] + 1]):
                    i = reader[m, 0]
                    if not bears[i] and read[reader[m, 1]] * push[k] > COUPLED:
                        pushing = _unit(worst, top(parent, j), row[i], s[i])
                        unit[i] = pushing if unit[i] == 0 or 0 < pushing < unit[i] else unit[i]
        for i in range(nc):
            if unit[i] == 0:
                unit[i] = own_speed(q, i, d)
            largest = max(largest, unit[i])
    for i in range(nc):
        cancelled = CANCELLED * size[i] if bears[i] else 0.0
        unit[i] = max(unit[i], cancelled, NOISE * largest) if unit[i] > 0 else largest
    return unit, island


@part
def _unit(worst, tree, row, s):  # type: ignore[no-untyped-def]
    """The unit of a contact, in its own dimension, from the largest demand, speed and terms of its island, worst[tree]."""
    root = np.sqrt(s)  # numbers instead of vectors, which would be allocated for each contact
    needed = worst[tree, 0, 2] * root if row else max(worst[tree, 0, 0], worst[tree, 0, 1] * root)
    fastest = worst[tree, 1, 2] * root if row else max(worst[tree, 1, 0], worst[tree, 1, 1] * root)
    terms = worst[tree, 2, 2] * root if row else max(worst[tree, 2, 0], worst[tree, 2, 1] * root)
    return max(needed if needed > NOISE * terms else fastest, CANCELLED * terms)


@kernel
def spread(units):  # type: ignore[no-untyped-def]
    """The largest unit divided by the smallest; 1 if nothing moves."""
    least = largest = units[0] if len(units) else 0.0
    for unit in units:
        least, largest = min(least, unit), max(largest, unit)
    return largest / least if least > 0 else 1.0


@part
def _bearing(start, node, push, read, nodes, closes, q, s, b_f, needed, speed, terms):  # type: ignore[no-untyped-def]
    """(nc,): whether each contact may carry load. speed and terms of contacts that open are reduced to their bounds."""
    nc, d, bears, most = len(s), len(q) // max(len(s), 1), np.ones(len(s), np.bool_), speed.max() if len(s) else 0.0
    if closes.all() or most == 0:
        return bears
    parent = _components(start, node, push, read, nodes, bears)
    energy = np.zeros(nc + nodes)
    for i in range(nc):
        counted = speed[i] if closes[i] else needed[i]
        energy[top(parent, i)] += (counted / most) ** 2 / s[i]
    for i in range(nc):
        if not closes[i]:
            transmitted = most * np.sqrt(s[i] * energy[top(parent, i)])
            pushed = q[i * d] <= FAR * transmitted
            bears[i] = pushed or s[i] * b_f[i] > COUPLED * transmitted
            counted = max(needed[i], CANCELLED * terms[i])
            speed[i] = terms[i] = max(counted, min(speed[i], FAR * transmitted)) if pushed else counted
    return bears


@kernel
def islands(start, node, push, read, nodes):  # type: ignore[no-untyped-def]
    """(nc,): the island of each contact, numbered from 0 in the order of their first contacts."""
    nc = len(start) - 1
    return numbered(_components(start, node, push, read, nodes, np.ones(nc, np.bool_)), nc)[:nc]


@part
def numbered(parent, nc):  # type: ignore[no-untyped-def]
    """The number of each node's tree in a forest, from 0 in the order of the first nc nodes; -1 for trees without these."""
    number, labels, count = np.full(len(parent), -1), np.empty(len(parent), np.int64), 0
    for i in range(len(parent)):
        root = top(parent, i)
        if i < nc and number[root] < 0:
            number[root] = count
            count += 1
        labels[i] = number[root]
    return labels


@part
def _components(start, node, push, read, nodes, linked):  # type: ignore[no-untyped-def]
    """A forest of contacts and nodes, with one tree for each island of the contacts that are linked (nc,)."""
    nc = len(start) - 1
    parent, pushed, felt = np.empty(nc + nodes, np.int64), np.zeros(nodes), np.zeros(nodes)
    for i in range(nc + nodes):
        parent[i] = i
    for i in range(nc):
        for k in range(start[i], start[i + 1] if linked[i] else start[i]):
            pushed[node[k]] = max(pushed[node[k]], push[k])
            felt[node[k]] = max(felt[node[k]], read[k])
    for i in range(nc):
        for k in range(start[i], start[i + 1] if linked[i] else start[i]):
            if push[k] * felt[node[k]] > COUPLED or read[k] * pushed[node[k]] > COUPLED:
                parent[top(parent, i)] = top(parent, nc + node[k])
    return parent


@part
def _readers(start, node, read, nodes):  # type: ignore[no-untyped-def]
    """The contacts that read each node, and the positions k of their entries: reader[first[v]:first[v+1]] = (contact, k)."""
    nc = len(start) - 1
    first = np.zeros(nodes + 1, np.int64)
    for k in range(start[nc]):
        first[node[k] + 1] += read[k] > 0
    for v in range(nodes):
        first[v + 1] += first[v]
    reader, end = np.empty((first[nodes], 2), np.int64), first.copy()
    for i in range(nc):
        for k in range(start[i], start[i + 1]):
            if read[k] > 0:
                reader[end[node[k]], 0], reader[end[node[k]], 1] = i, k
                end[node[k]] += 1
    return first, reader


@part
def top(parent, i):  # type: ignore[no-untyped-def]
    """The root of i's tree."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@part
def length(q, first, d):  # type: ignore[no-untyped-def]
    """The length of d entries of q from the first, computed without overflow or underflow of its square. Slices of q would take
    longer than the sum, as references to arrays are counted."""
    square = most = 0.0
    for a in range(first, first + d):
        square += q[a] * q[a]
        most = max(most, abs(q[a]))
    if 1e-290 < square < 1e290 or most in (0.0, np.inf):
        return np.sqrt(square)
    square = 0.0
    for a in range(first, first + d):
        square += (q[a] / most) ** 2
    return most * np.sqrt(square)
