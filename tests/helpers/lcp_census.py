"""The census of a bare LCP: all of its solutions, enumerated over the choices z_i = 0 or w_i = 0 of each pair."""

import numpy as np

from frictionbench.problems import LCP
from frictionbench.problems.analysis.census import WRONG_RESIDUAL, Census, enumerate_solutions


def lcp_census(lcp: LCP) -> Census:
    """All solutions of an LCP, q scaled to unit size; x is z, y is w, and a letter tells which of a pair is nonzero."""
    n = lcp.size
    free = np.abs(lcp.q).max(initial=0.0) or 1.0
    z, w = np.eye(n + 1), np.column_stack([lcp.dense, lcp.q / free])
    choices = [[("z", ((w[i], True),)), ("w", ((z[i], True), (w[i], False)))] for i in range(n)]
    unit = np.full(n, free)
    return enumerate_solutions(z, [], choices, w, unit, unit, lambda x: lcp.residual(x) <= WRONG_RESIDUAL)
