"""The islands of a problem, and the velocity in which the residual of each contact is measured.

Contacts are coupled where an impulse of one changes the velocity of the other. The impulse that stops contact j's own velocity
|q_j| changes that of contact i by a share |W_ij| / s_j of it; below COUPLED the share counts as none, so that bodies which rest
on one very heavy body are apart. An *island* is a connected component of this graph. A contact's *unit* (m/s) is the largest
velocity that can reach it: max |q_j| over the contacts j that can bear and from which a path of couplings leads to it, as a
rule those of its island. Islands next to one another do not change each other's units.

A contact that opens, q_n,i > 0, bears only if others push it. From Coulomb's law r'u <= 0, hence r'Wr <= -r'q: the impulses
have at most the energy of what they stop, and change contact i's velocity by at most sqrt(s_i) times its root. With

    E_i = sum_j |q_j|^2 / s_j      over the contacts j of its island that close, q_n,j <= 0 to rounding,

it counts as at most FAR sqrt(s_i E_i), however fast it slides, or as CANCELLED |q_i|, so that its own rounding can be judged;
where q_n,i exceeds FAR sqrt(s_i E_i), it is open in any answer by far, r_i = 0, and is left out as a link too. A contact with a
friction bias counts at least as what b_f can stop of its sliding, also in the sum, and as CANCELLED |q_i|. E_i is an estimate
of the energy, invariant under changes of frame, of units and of the observer's velocity. A contact that counts too little makes
the measure stricter.

q is a sum of terms J v* and b, and known to rounding only: a contact's velocity counts as at least CANCELLED of their size, and
a unit is at least NOISE of the largest. Where nothing in an island moves, its unit is the largest of the problem.

Of given mechanics W is not formed: a contact acts on the velocities that it touches, |W_ij| <= sum_v |J_iv| |J_jv| / m_v, and
bodies that the mass matrix or joints connect are one.

Most problems are one island that its fastest contact reaches, in which all contacts can bear. That is found first, without the
graph and in squares of shares; where it is not found, the graph decides.
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part

COUPLED = 1e-10  # share of a velocity that is transmitted: mass ratios of neighbours up to 1e10 leave an island connected
FAR = 10.0  # the sum is less than the energy where contacts share bodies: by the root of their number, for equal masses
CANCELLED = 1e-6  # so that the rounding floor of contacts at rest on moving bodies is some 1e-9
LEVEL = 1e-12  # share of a contact's speed below which it is not known to open
NOISE = 1e-14  # some fifty roundings
PASSES = 6  # to and fro: two find the contacts of a pile that are numbered by layers


@kernel
def mechanical_units(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, f_start, f_column, free, bias, q, s, wider, terms
):
    """The units (nc,) of given mechanics.

    free: v* (nv,). f_start, f_column: the entries of the joints' rows. wider: the friction bias (nc,). terms: (nc, d), the size
    of the terms of q where there are joints, otherwise empty.
    """
    nc, d = len(s), J.shape[1]
    least, size, closes = np.empty(nc), np.empty(d), np.empty(nc, np.bool_)
    for i in range(nc):
        for a in range(d):
            size[a] = terms[i, a] if len(terms) else abs(bias[i]) if a == 0 else 0.0
            if len(terms) == 0:
                for k in range(start[i], start[i + 1]):
                    size[a] += abs(J[k, a] * free[column[k]])
        least[i] = CANCELLED * length(size, 0, d)
        closes[i] = q[i * d] <= max(CANCELLED * size[0], LEVEL * length(q, i, d))
    graph = mechanical_graph(start, column, J, m_start, m_column, m_value, f_start, f_column, s)
    return _reached(*graph, least, closes, q, s, wider)


@kernel
def delassus_units(first, neighbours, block, q, s, wider):  # type: ignore[no-untyped-def]
    """The units (nc,) where only W, by blocks, and q are known."""
    nc, d = len(s), block.shape[1]
    source, most = _source(q, s)
    if most > 0 and _reaches_all_in_w(first, neighbours, block, s, source):
        return np.full(nc, most)
    least, closes = np.empty(nc), np.empty(nc, np.bool_)
    for i in range(nc):
        speed = length(q, i, d)
        least[i], closes[i] = CANCELLED * speed, q[i * d] <= LEVEL * speed
    return _reached(*delassus_graph(first, neighbours, block, s), least, closes, q, s, wider)


@part
def one_island(start, column, J, share, free, bias, q, s):  # type: ignore[no-untyped-def]
    """max |q_i|, where it is found that this is the unit of every contact, of given mechanics without joints; otherwise 0.

    share: |J_iv|^2 / m_v of a diagonal mass matrix, as J by contacts.
    """
    nc, nv = len(s), len(free)
    source, most = _source(q, s)
    if most == 0:
        return 0.0
    lever, speed, offset, entries = 0.0, 0.0, 0.0, 0
    for k in range(len(column)):
        for a in range(J.shape[1]):
            lever = max(lever, abs(J[k, a]))
    for v in range(nv):
        speed = max(speed, abs(free[v]))
    for i in range(nc):
        offset, entries = max(offset, abs(bias[i])), max(entries, start[i + 1] - start[i])
    terms = offset + entries * J.shape[1] * lever * speed  # at least the size of those of any q_i
    return most if most >= CANCELLED * terms and _reaches_all(start, column, share, nv, s, source) else 0.0


@part
def _source(q, s):  # type: ignore[no-untyped-def]
    """The contact with the largest |q_i|, and that, if it counts in full and all contacts can bear where they are one island,
    otherwise 0."""
    nc = len(s)
    if nc == 0:
        return 0, 0.0
    d = len(q) // nc
    energy, opening, fastest, source = 0.0, 0.0, 0.0, 0
    for i in range(nc):
        normal, light, square = q[i * d], 1 / s[i], 0.0
        for a in range(d):
            square += q[i * d + a] * q[i * d + a]
        if normal <= 0 or normal * normal <= LEVEL * LEVEL * square:
            energy += square * light
        else:
            opening = max(opening, normal * normal * light)
        if square > fastest:
            source, fastest = i, square
    regular = 1e-280 < fastest < 1e280 and 1e-290 < energy < 1e290  # squares neither overflow nor vanish
    if q[source * d] > LEVEL * np.sqrt(fastest):
        opening = max(opening, fastest / s[source])
    return source, np.sqrt(fastest) if regular and opening <= FAR * FAR * energy else 0.0


@part
def _reaches_all(start, column, share, nv, s, source):  # type: ignore[no-untyped-def]
    """Whether contact source's velocity reaches all others, as far as PASSES over the contacts find, to and fro."""
    nc, known = len(s), 0
    felt, reached = np.zeros(nv), np.zeros(nc, np.bool_)
    for turn in range(PASSES):
        for at in range(nc + 1):
            i = source if at == 0 else at - 1 if turn % 2 == 0 else nc - at
            coupled = at == 0
            if reached[i]:
                continue
            for k in range(start[i], start[i + 1]):
                if coupled:
                    break
                coupled = share[k] * felt[column[k]] > COUPLED * COUPLED
            if coupled:
                reached[i] = True
                known += 1
                for k in range(start[i], start[i + 1]):
                    felt[column[k]] = max(felt[column[k]], share[k] / s[i] / s[i])
        if known == nc:
            return True
    return False


@part
def _reaches_all_in_w(first, neighbours, block, s, source):  # type: ignore[no-untyped-def]
    """The same where only W is known."""
    nc, d = len(s), block.shape[1]
    reached, stack, height, known = np.zeros(nc, np.bool_), np.empty(nc, np.int64), 1, 1
    reached[source], stack[0] = True, source
    while height:
        height -= 1
        j = stack[height]
        for k in range(first[j], first[j + 1]):
            i = neighbours[k]
            if reached[i]:
                continue
            square = 0.0
            for a in range(d):
                square += _square(block[k], a, d)
            if square / s[j] / s[j] > COUPLED * COUPLED:
                reached[i], stack[height] = True, i
                height += 1
                known += 1
    return known == nc


@part
def _square(rows, k, d):  # type: ignore[no-untyped-def]
    """|rows[k]|^2."""
    square = 0.0
    for a in range(d):
        square += rows[k, a] * rows[k, a]
    return square


@kernel
def mechanical_graph(start, column, J, m_start, m_column, m_value, f_start, f_column, s):  # type: ignore[no-untyped-def]
    """Contacts and the nodes that they push and read, contact i at node[start[i]:start[i+1]]; the number of nodes.

    A velocity is a node, in units in which its kinetic energy is v^2/2; velocities that are coupled otherwise share one.
    push: what contact i's unit of velocity gives to a node; read: what a node's gives to the contact.
    """
    nv = len(m_start) - 1
    root, parent = np.empty(nv), np.empty(nv, np.int64)
    for v in range(nv):
        parent[v] = v
    for v in range(nv):
        for m in range(m_start[v], m_start[v + 1]):
            if m_column[m] == v:
                root[v] = np.sqrt(m_value[m])
            elif m_value[m] != 0:
                parent[top(parent, v)] = top(parent, m_column[m])
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
    """The same where only W is known: the contacts themselves are the nodes."""
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
def _reached(start, node, push, read, nodes, least, closes, q, s, wider):  # type: ignore[no-untyped-def]
    """The units: from the fastest contact on, all that its velocity reaches. least: CANCELLED of the terms of q_i."""
    nc, d = len(s), len(q) // max(len(s), 1)
    unit, stack, known = np.zeros(nc), np.empty(nc, np.int64), 0
    own, largest, fastest, source = np.empty(nc), 0.0, 0.0, 0
    for i in range(nc):
        own[i] = max(least[i], length(q, i, d))
        largest = max(largest, own[i])
    value, bears = _counted(start, node, push, read, nodes, own, largest, least, closes, q, s, wider)
    for i in range(nc):
        if bears[i] and value[i] > fastest:
            fastest, source = value[i], i
    first, reader = _readers(start, node, read, nodes)
    felt = np.zeros(nodes)
    order, at = np.empty(0, np.int64), 0
    while fastest > 0:
        unit[source], stack[0], height = value[source], source, 1
        known += 1
        while height:
            height -= 1
            j = stack[height]
            for k in range(start[j], start[j + 1]):
                v = node[k]
                if push[k] <= felt[v]:
                    continue
                felt[v] = push[k]
                for m in range(first[v], first[v + 1]):
                    i = reader[m, 0]
                    if unit[i] == 0 and read[reader[m, 1]] * push[k] > COUPLED:
                        unit[i] = value[source]
                        known += 1
                        if bears[i]:
                            stack[height] = i
                            height += 1
        if known == nc:
            break
        if len(order) == 0:
            order = np.argsort(-value)
        while at < nc and (unit[order[at]] > 0 or not bears[order[at]]):
            at += 1
        if at == nc or value[order[at]] == 0:
            break
        source = order[at]
    for i in range(nc):
        if unit[i] == 0:
            unit[i] = own[i] if own[i] > 0 else fastest if fastest > 0 else largest
        unit[i] = max(unit[i], NOISE * fastest)
    return unit


@kernel
def spread(units):  # type: ignore[no-untyped-def]
    """The largest unit over the smallest, 1 where nothing moves."""
    least = largest = units[0] if len(units) else 0.0
    for unit in units:
        least, largest = min(least, unit), max(largest, unit)
    return largest / least if least > 0 else 1.0


@part
def _counted(start, node, push, read, nodes, own, largest, least, closes, q, s, wider):  # type: ignore[no-untyped-def]
    """(nc,), (nc,): the velocity as which each contact counts, and whether it may bear. own: |q_i|, at least least_i."""
    nc, d = len(s), len(q) // max(len(s), 1)
    value, bears = own.copy(), np.ones(nc, np.bool_)
    if closes.all() or largest == 0:
        return value, bears
    parent = _components(start, node, push, read, nodes)
    energy, biased = np.zeros(nc + nodes), np.zeros(nc)
    for i in range(nc):
        if not closes[i] and wider[i] > 0:
            sliding = length(q[i * d + 1 : i * d + d], 0, d - 1)
            biased[i] = min(max(sliding, least[i]), s[i] * wider[i])
        energy[top(parent, i)] += ((own[i] if closes[i] else biased[i]) / largest) ** 2 / s[i]
    for i in range(nc):
        if not closes[i]:
            given = largest * np.sqrt(s[i] * energy[top(parent, i)])
            pushed = q[i * d] <= FAR * given
            bears[i] = pushed or s[i] * wider[i] > COUPLED * given
            known = max(biased[i], least[i] if wider[i] > 0 else 0.0)
            value[i] = max(min(own[i], max(FAR * given, least[i])) if pushed else 0.0, known)
    return value, bears


@kernel
def islands(start, node, push, read, nodes):  # type: ignore[no-untyped-def]
    """(nc,): the island of each contact, numbered from 0 in the order of their first contacts."""
    parent, nc = _components(start, node, push, read, nodes), len(start) - 1
    number, island, count = np.full(nc + nodes, -1, np.int64), np.empty(nc, np.int64), 0
    for i in range(nc):
        tree = top(parent, i)
        if number[tree] < 0:
            number[tree] = count
            count += 1
        island[i] = number[tree]
    return island


@part
def _components(start, node, push, read, nodes):  # type: ignore[no-untyped-def]
    """A forest over contacts and nodes, one tree for each island."""
    nc = len(start) - 1
    parent, pushed, felt = np.empty(nc + nodes, np.int64), np.zeros(nodes), np.zeros(nodes)
    for i in range(nc + nodes):
        parent[i] = i
    for k in range(start[nc]):
        pushed[node[k]] = max(pushed[node[k]], push[k])
        felt[node[k]] = max(felt[node[k]], read[k])
    for i in range(nc):
        for k in range(start[i], start[i + 1]):
            if push[k] * felt[node[k]] > COUPLED or read[k] * pushed[node[k]] > COUPLED:
                parent[top(parent, i)] = top(parent, nc + node[k])
    return parent


@part
def _readers(start, node, read, nodes):  # type: ignore[no-untyped-def]
    """The contacts that read each node, and where: reader[first[v]:first[v+1]] = (contact, k)."""
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
def length(q, i, d):  # type: ignore[no-untyped-def]
    """|q_i|, also where its square would overflow or vanish."""
    square = most = 0.0
    for a in range(d):
        square += q[i * d + a] * q[i * d + a]
        most = max(most, abs(q[i * d + a]))
    if 1e-290 < square < 1e290 or most in (0.0, np.inf):
        return np.sqrt(square)
    square = 0.0
    for a in range(d):
        square += (q[i * d + a] / most) ** 2
    return most * np.sqrt(square)
