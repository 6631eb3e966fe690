"""Cholesky factorisation A = L L' of a symmetric positive semidefinite band matrix, without its dependent rows.

A matrix of half bandwidth b is stored by rows in band (n, b+1): band[i, k] is its entry in column i - b + k. Rows whose pivot
is a rounding error are left out: their unknowns are zero, and the result is X with A X A = A, the inverse of the other rows.
References: Golub and Van Loan, section 4.3.5; Takahashi, Fagan and Chen 1973 for the entries of the inverse.
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part


@kernel
def factorise(band, least):  # type: ignore[no-untyped-def]
    """Overwrite A by L. Rows whose pivot is at most `least` times their diagonal entry are set to zero."""
    n, b = len(band), band.shape[1] - 1
    for i in range(n):
        size = band[i, b]
        for j in range(max(0, i - b), i):
            if band[j, b] == 0:
                band[i, j - i + b] = 0.0
                continue
            total = band[i, j - i + b]
            for k in range(max(0, i - b), j):
                total -= band[i, k - i + b] * band[j, k - j + b]
            band[i, j - i + b] = total / band[j, b]
        pivot = size
        for k in range(b):
            pivot -= band[i, k] * band[i, k]
        if pivot <= least * size:
            for k in range(b + 1):
                band[i, k] = 0.0
        else:
            band[i, b] = np.sqrt(pivot)


@part
def solve_lower(L, y):  # type: ignore[no-untyped-def]
    """Overwrite y by L^-1 y, with zeros in the rows left out."""
    n, b = len(L), L.shape[1] - 1
    for i in range(n):
        if L[i, b] == 0:
            y[i] = 0.0
            continue
        for k in range(max(0, b - i), b):
            y[i] -= L[i, k] * y[i - b + k]
        y[i] /= L[i, b]


@part
def solve_upper(L, y):  # type: ignore[no-untyped-def]
    """Overwrite y by L'^-1 y, with zeros in the rows left out."""
    n, b = len(L), L.shape[1] - 1
    for i in range(n - 1, -1, -1):
        if L[i, b] == 0:
            y[i] = 0.0
            continue
        y[i] /= L[i, b]
        for k in range(max(0, b - i), b):
            y[i - b + k] -= L[i, k] * y[i]


@kernel
def whiten(L, rows):  # type: ignore[no-untyped-def]
    """Overwrite each of the dense rows (k, n) by L^-1 times it."""
    for row in rows:
        solve_lower(L, row)


@kernel
def inverse_in_band(L):  # type: ignore[no-untyped-def]
    """The entries of X within the band, stored like those of A."""
    n, b = len(L), L.shape[1] - 1
    X = np.zeros(L.shape)
    for i in range(n - 1, -1, -1):
        if L[i, b] == 0:
            continue
        end = min(n, i + b + 1)
        for j in range(end - 1, i - 1, -1):
            total = 1 / L[i, b] if j == i else 0.0
            for k in range(i + 1, end):
                low, high = min(j, k), max(j, k)
                total -= L[k, i - k + b] * X[high, low - high + b]
            X[j, i - j + b] = total / L[i, b]
    return X


@kernel
def forms(X, start, column, value):  # type: ignore[no-untyped-def]
    """c' X c and |c|' |X| |c| (rows, 2) for each row c of a matrix by rows, whose columns are at most b apart."""
    b, result = X.shape[1] - 1, np.zeros((len(start) - 1, 2))
    for i in range(len(result)):
        for k in range(start[i], start[i + 1]):
            for m in range(start[i], start[i + 1]):
                low, high = min(column[k], column[m]), max(column[k], column[m])
                term = value[k] * X[high, low - high + b] * value[m]
                result[i, 0] += term
                result[i, 1] += abs(term)
    return result


@kernel
def hold(L, start, column, F, r_start, r_column, response, bias, velocity):  # type: ignore[no-untyped-def]
    """velocity - R X (F velocity + bias), with R = M^-1 F' by columns; applied twice to reduce rounding errors."""
    v, y = velocity.copy(), np.empty(len(bias))
    for _ in range(2):
        for j in range(len(bias)):
            y[j] = bias[j]
            for k in range(start[j], start[j + 1]):
                y[j] += F[k] * v[column[k]]
        solve_lower(L, y)
        solve_upper(L, y)
        for j in range(len(bias)):
            for k in range(r_start[j], r_start[j + 1]):
                v[r_column[k]] -= response[k] * y[j]
    return v
