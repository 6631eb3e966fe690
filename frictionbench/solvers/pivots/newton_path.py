"""A pivotal path: from a basic point at t = 0 towards t = 1 along  M z - w + t cover = b,  0 <= z ⟂ w >= 0.

t enters the basis first, then always the complement of the variable that left, as in Lemke's method, until t reaches 1. The
ratio test is Harris's (1973): among the basic variables that would be the first to pass a small slip below zero, the one with
the largest pivot leaves. Small pivots and rays are accepted only after a fresh factorisation. There is no rule for exact ties:
from a random starting point none occur before t = 1, where they no longer matter.
"""

import numpy as np

from frictionbench.problems.compiled import part
from frictionbench.solvers.clock import late
from frictionbench.solvers.pivots.lu_basis import (
    column,
    factorise_basis,
    ftran,
    largest_magnitude,
    replace_column,
)
from frictionbench.solvers.pivots.vectors import fill, put

DEPENDENT_COLUMN = 1e-12  # a column is dependent if elimination leaves less than this share of it, which is then rounding
LEAST_RATE = 1e-9  # smaller rates of change, relative to the largest, count as zero: they may be rounding of 96 updates
UNRELIABLE = 1e-7  # smaller pivots are taken only from a fresh factorisation, without the rounding of updates
SLIP = 1e-10  # how far below zero a basic variable may go for the sake of a larger pivot, in units of the scaled q

NEWTON, RAY, LIMIT, SINGULAR, RETURNED = range(5)  # how a path ends, as STATUSES: t = 1, ray, limit, no regular basis, t = 0
PIVOTS, FACTORISATIONS = 0, 1  # indices of work


@part
def follow_newton_path(basis, columns, b, v, limit, until, work):  # type: ignore[no-untyped-def]
    """Follow M z - w + t cover = b from the factorised basis at t = 0 towards t = 1; return how the path ends.

    v (n,) receives z of the end point (NEWTON), whose basis is then stored, or of the ray (RAY).
    """
    n = len(b)
    t = entering = 2 * n
    t_at = -1
    d, x = np.empty(n), np.empty(n)
    put(x, b)
    ftran(basis, columns, x)
    while True:
        column(columns, entering, d)
        ftran(basis, columns, d)
        size = max(largest_magnitude(d), 1.0)
        if size == np.inf:
            return SINGULAR
        remaining = 1.0 if entering == t else np.inf  # until t = 1
        if t_at >= 0 and d[t_at] < -LEAST_RATE * size:
            remaining = max(1.0 - x[t_at], 0.0) / -d[t_at]
        reach = np.inf  # until a basic variable is at minus SLIP
        for i in range(n):
            if d[i] > LEAST_RATE * size:
                reach = min(reach, (max(x[i], 0.0) + SLIP) / d[i])
        if remaining <= reach and remaining < np.inf:
            for i in range(n):
                x[i] -= remaining * d[i]
            if entering != t:
                basis.head[t_at] = entering
                x[t_at] = remaining
            write_z(basis, x, v)
            return NEWTON
        p = n  # none
        for i in range(n):
            if d[i] > LEAST_RATE * size and x[i] <= reach * d[i] and (p == n or d[i] > d[p]):
                p = i
        renew = basis.size[1] > 0 and (p == n or d[p] < UNRELIABLE * size)
        if not renew:
            if p == n:
                for i in range(n):
                    d[i] = -d[i]
                write_z(basis, d, v)
                if entering < n:
                    v[entering] = 1.0
                return RAY
            if p == t_at:
                return RETURNED
            if work[PIVOTS] == limit or late(until):
                return LIMIT
            step = max(x[p], 0.0) / d[p]
            for i in range(n):
                x[i] -= step * d[i]
            x[p] = step
            t_at = p if entering == t else t_at
            leaving = basis.head[p]
            renew = replace_column(basis, p, entering, d)
            entering = leaving + n if leaving < n else leaving - n
            work[PIVOTS] += 1
        if renew:
            work[FACTORISATIONS] += 1
            if factorise_basis(basis, columns, DEPENDENT_COLUMN, until):
                return SINGULAR
            put(x, b)
            ftran(basis, columns, x)
            for i in range(n):
                if basis.head[i] == t:
                    t_at = i


@part
def write_z(basis, x, z):  # type: ignore[no-untyped-def]
    """Overwrite z (n,) with the basic z of the values x (n,), and zeros."""
    fill(z, 0.0)
    for i in range(len(z)):
        if basis.head[i] < len(z):
            z[basis.head[i]] = x[i]
