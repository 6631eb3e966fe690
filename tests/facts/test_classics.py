"""Classic LCPs from the literature: all their solutions by the census, and what the LCP methods make of them."""

import numpy as np
import pytest

from frictionbench.problems import LCP
from frictionbench.problems.analysis.polyhedra import Shape
from frictionbench.solvers import Status, solve
from tests.helpers.lcp_census import lcp_census


def murty(n) -> LCP:
    """Lower triangular, 1 on the diagonal and 2 below it; q_i = -(2^n + ... + 2^(n-i+1)) (Murty 1988, chapter 6)."""
    return LCP(np.eye(n) + 2 * np.tril(np.ones((n, n)), -1), -np.cumsum(2.0 ** np.arange(n, 0, -1)))


def fathi(n) -> LCP:
    """L L' of Murty's matrix L, q = -1 (Fathi 1979): symmetric positive definite."""
    L = murty(n).dense
    return LCP(L @ L.T, -np.ones(n))


def bimatrix(A, B) -> LCP:
    """The Nash equilibria of the costs A, B > 0 as z = (x, y), each up to a factor (Cottle and Dantzig 1968)."""
    m, n = np.shape(A)
    M = np.block([[np.zeros((m, m)), np.array(A)], [np.array(B).T, np.zeros((n, n))]])
    return LCP(M, -np.ones(m + n))


def handbook(level) -> tuple[LCP, list[np.ndarray]]:
    """10.2.9: z = ((l + 16)/13, (l + 16)/13, 2 (23 - l)/13, (1286 - 9 l)/13), 0 <= l <= 23."""
    lcp = LCP([[11, 0, 10, -1], [0, 11, 10, -1], [10, 10, 21, -1], [1, 1, 1, 0]], [50, 50, level, -6])
    return lcp, [np.array([level + 16, level + 16, 2 * (23 - level), 1286 - 9 * level]) / 13]


# name: (problem, its isolated solutions), from the sources named; "handbook" is Floudas and Pardalos (1999)
P_MATRICES = {
    "kostreva (1979), where naive ties cycle": (LCP([[1, 2, 0], [0, 1, 2], [2, 0, 1]], -np.ones(3)), [[1 / 3, 1 / 3, 1 / 3]]),
    "two by two": (LCP([[2, 1], [0, 2]], [-1, -2]), [[0, 1]]),
    "murty (1988), chapter 6": (murty(8), [256 * np.eye(8)[0]]),
    "fathi (1979)": (fathi(8), [np.eye(8)[0]]),
}
ISOLATED = P_MATRICES | {
    "murty (1988) example 2.8": (
        LCP([[1, -1, -1, -1], [-1, 1, -1, -1], [1, 1, 2, 0], [1, 1, 0, 2]], [3, 5, -9, -5]),
        [[2, 1, 3, 1]],
    ),
    "murty (1988) example 2.9": (LCP([[-1, 0, -3], [1, -2, -5], [-2, -1, -2]], [-3, -2, -1]), []),
    "two by two, a ray": (LCP([[2, -1], [0, -2]], [-1, -2]), []),
    "zero": (LCP([[0]], [-1]), []),
    "cottle, pang and stone (2009) 4.4.7": (LCP([[0, -1, 2], [2, 0, -2], [-1, 1, 0]], [-3, 6, -1]), [[0, 1, 3]]),
    "handbook 10.2.4, a bimatrix game": (
        bimatrix([[10, 20], [30, 15]], np.transpose([[10, 20], [30, 15]])),
        [[1 / 10, 0, 1 / 10, 0], [0, 1 / 15, 0, 1 / 15], [1 / 90, 2 / 45, 1 / 90, 2 / 45]],
    ),
    "path's example": (
        LCP([[0, 0, -1, -1], [0, 0, 1, -2], [1, -1, 2, -2], [1, 2, -2, 4]], [2, 2, -2, -6]),
        [[2.8, 0, 0.8, 1.2]],
    ),
    **{f"handbook 10.2.9, l = {level}": handbook(level) for level in (0, 10, 23)},
}
LEMKE, PATH, PRINCIPAL = ("lemke", "lemke[restarts=0]"), ("path_search", "path_search[crash=0]"), ("dantzig", "murty")


@pytest.mark.parametrize("name", ISOLATED)
def test_all_solutions(name) -> None:
    lcp, known = ISOLATED[name]
    found = lcp_census(lcp)
    assert found.count == len(known)
    for z in known:
        assert sum(piece.vertices[0] == pytest.approx(z, abs=1e-9) for piece in found.pieces) == 1
    assert found.shape is (Shape.NONE, Shape.ONE, Shape.ISOLATED)[min(len(known), 2)]


@pytest.mark.parametrize("name", ISOLATED)
@pytest.mark.parametrize("spec", [*LEMKE, *PATH, *PRINCIPAL, "fischer_newton", "minmap_newton"])
def test_a_method_returns_a_solution_or_says_that_it_has_none(spec, name) -> None:
    """Every positive covering vector leads Lemke's method to a ray of the bimatrix game. Principal pivots are sure for
    P-matrices alone, and Newton's method here solves those of them that are listed."""
    lcp, known = ISOLATED[name]
    answer = solve(lcp, spec, tol=1e-10)
    if answer.status is Status.SOLVED:
        assert lcp.residual(answer.z) <= 1e-10
        assert any(answer.z == pytest.approx(z, rel=1e-7, abs=1e-7) for z in known)
    elif spec in LEMKE:
        assert not known or "bimatrix" in name
        assert answer.status is Status.RAY
    else:
        assert not known or (spec not in PATH and name not in P_MATRICES)


@pytest.mark.parametrize("n", [2, 5, 10])
def test_pivot_counts(n) -> None:
    """2^n of Lemke's method with d = 1; 2^n - 1 of Murty's, on the transpose and q = -1 (Murty 1988, chapter 6). Of Fathi's
    family it were 2^n too; once M has a unit diagonal the same d is harmless."""
    lcp = murty(n)
    assert solve(lcp, "lemke[restarts=0]").work["pivots"] == 2**n
    assert solve(LCP(lcp.dense.T, -np.ones(n)), "murty").work["pivots"] == 2**n - 1
    assert solve(fathi(n), "lemke").work["pivots"] <= n
