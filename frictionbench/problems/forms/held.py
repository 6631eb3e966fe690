"""Kernels that satisfy joint equations F v + b_F = 0 with a dense inverse of G = F M^-1 F', for few equations of any rank.

Redundant equations make G singular; any X with G X G = G gives the same velocities, v - M^-1 F' X (F v + b_F). X is the
inverse of the rows of G that a pivoted Cholesky factorisation selects, and zero elsewhere. Arrays are as in problems.rows;
there may be no equations.
"""

import numpy as np

from frictionbench.problems.compiled import kernel
from frictionbench.problems.forms.delassus import joint_response, product
from frictionbench.problems.forms.islands import EPSILON

# A row depends on earlier ones if its pivot, divided by its diagonal entry of G, is at most this times nj.
DEPENDENT_ROW = 10 * EPSILON
PASSES = 2  # of `hold`: the second removes the defect that rounding of the inverse leaves if rows are nearly dependent


@kernel
def joint_inverse(f_start, f_column, F, m_start, m_column, m_value):  # type: ignore[no-untyped-def]
    """M^-1 F' (nv, nj) and the symmetric X (nj, nj)."""
    response = joint_response(f_start, f_column, F, m_start, m_column, m_value)
    return response, generalised_inverse(product(f_start, f_column, F, response))


@kernel
def generalised_inverse(G):  # type: ignore[no-untyped-def]
    """X with G X G = G for a symmetric positive semidefinite G (nj, nj).

    The rank is that of G scaled to a unit diagonal, so that it does not depend on the units of the joint equations.
    """
    nj, rank = len(G), 0
    unit, left, order, L = np.empty(nj), np.empty(nj), np.arange(nj), np.empty((nj, nj))  # L[k]: the factor's column k
    for i in range(nj):
        unit[i] = 1 / np.sqrt(G[i, i]) if G[i, i] > 0 else 1.0
        left[i] = G[i, i] * unit[i] * unit[i]
    while rank < nj:
        best = rank
        for i in range(rank + 1, nj):
            if left[order[i]] > left[order[best]]:
                best = i
        p = order[best]
        if not left[p] > DEPENDENT_ROW * nj:
            break
        order[best], order[rank] = order[rank], p
        pivot, column = np.sqrt(left[p]), L[rank]
        for j in range(nj):
            column[j] = unit[j] * G[j, p] * unit[p]
        for k in range(rank):
            earlier = L[k]
            for j in range(nj):
                column[j] -= earlier[j] * earlier[p]
        for j in range(nj):
            column[j] /= pivot
            left[j] -= column[j] * column[j]
        column[p] = pivot
        rank += 1
    root, X = np.zeros((rank, rank)), np.zeros((nj, nj))  # the inverse of the selected rows' factor
    for i in range(rank):
        root[i, i] = 1.0
        for k in range(i):
            factor = L[k, order[i]]
            for c in range(k + 1):
                root[i, c] -= factor * root[k, c]
        for c in range(i + 1):
            root[i, c] /= L[i, order[i]]
    inner = np.zeros((rank, rank))
    for k in range(rank):
        for a in range(k + 1):
            factor = root[k, a]
            for b in range(a + 1):
                inner[a, b] += factor * root[k, b]
    for a in range(rank):
        for b in range(rank):
            X[order[a], order[b]] = unit[order[a]] * inner[max(a, b), min(a, b)] * unit[order[b]]
    return X


@kernel
def hold(f_start, f_column, F, bias, response, X, velocity):  # type: ignore[no-untyped-def]
    """The nearest velocity (nv,), in the kinetic metric, that satisfies the equations."""
    nv, nj = response.shape
    held, off = np.empty(nv), np.empty(nj)
    for v in range(nv):
        held[v] = velocity[v]
    for _ in range(PASSES if nj else 0):
        for j in range(nj):
            off[j] = bias[j]
            for k in range(f_start[j], f_start[j + 1]):
                off[j] += F[k] * held[f_column[k]]
        for j in range(nj):
            push = 0.0
            for k in range(nj):
                push += X[j, k] * off[k]
            for v in range(nv):
                held[v] -= response[v, j] * push
    return held


@kernel
def hold_rounding(f_start, f_column, F, bias, response, X, velocity, held):  # type: ignore[no-untyped-def]
    """(nv,): the size of the terms that `hold` adds to a velocity; held: its result. They are the terms of the first pass, the
    effect of X on the terms of F v + b_F in the second pass, and the change by another `hold` divided by 2 eps."""
    nv, nj = response.shape
    off, terms = np.empty(nj), np.empty(nj)
    size = np.abs(hold(f_start, f_column, F, bias, response, X, held) - held) / (2 * EPSILON)
    for j in range(nj):
        off[j], terms[j] = bias[j], abs(bias[j])
        for k in range(f_start[j], f_start[j + 1]):
            off[j] += F[k] * velocity[f_column[k]]
            terms[j] += abs(F[k] * held[f_column[k]])
    for j in range(nj):
        push = spread = 0.0
        for k in range(nj):
            push += X[j, k] * off[k]
            spread += abs(X[j, k]) * terms[k]
        for v in range(nv):
            size[v] += abs(response[v, j]) * (abs(push) + spread)
    return size
