"""Siconos on recorded problems, for tests/benchmarks/peers.py: Debian builds it for the system's Python only.

    siconos_child.py PROBLEMS.npz SOLVER

PROBLEMS.npz holds for problem i its W{i}, q{i}, mu{i} (normal first) and in the plane its LCP's M{i}, b{i}. A line with a
number i asks for problem i; the reply is one line of JSON, [least seconds of a solve, the answer]. Siconos may print, abort or
hang: replies have a stream of their own, and whoever started this process kills it.
"""

import json
import os
import sys
import time

import numpy as np
import siconos.numerics as sn

TOLERANCE, SWEEPS, BUDGET = 1e-9, 100_000, 2e-3  # of the iterative solvers; seconds over which a solve is repeated


def least(solve):
    """Least seconds of a solve from zero, and its answer; the clock is around the driver alone."""
    best, spent = np.inf, 0.0
    while spent < BUDGET:
        seconds, answer = solve()
        best, spent = min(best, seconds), spent + seconds
    return best, answer.tolist()


def from_zero(driver, given, n, options):
    r, u = np.zeros(n), np.zeros(n)
    start = time.perf_counter()
    driver(given, r, u, options)
    return time.perf_counter() - start, r


def friction(W, q, mu, dimension, solver):
    options = sn.SolverOptions(solver)
    options.dparam[sn.SICONOS_DPARAM_TOL] = TOLERANCE
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = SWEEPS
    given = sn.FrictionContactProblem(dimension, len(mu), W, q, mu)
    driver = sn.fc2d_driver if dimension == 2 else sn.fc3d_driver
    return least(lambda: from_zero(driver, given, len(q), options))


def raised(W, q):
    """The planar problem in space: a second tangent that nothing moves, with the first one's inertia."""
    n = len(q) // 2
    planar = (3 * np.arange(n)[:, None] + [0, 1]).ravel()
    third = 3 * np.arange(n) + 2
    W3, q3 = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    W3[np.ix_(planar, planar)], q3[planar] = W, q
    W3[third, third] = W.diagonal()[1::2]
    return W3, q3


def main():
    replies = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    problems, solver = np.load(sys.argv[1]), sys.argv[2]
    kind = getattr(sn, "SICONOS_" + solver)
    for line in sys.stdin:
        W, q, mu = (problems[name + line.strip()] for name in ("W", "q", "mu"))
        if solver.startswith("LCP"):
            M, b = problems["M" + line.strip()], problems["b" + line.strip()]
            given, options = sn.LCP(M, b), sn.SolverOptions(kind)
            driver = sn.linearComplementarity_driver
            reply = least(lambda: from_zero(driver, given, len(b), options))  # noqa: B023
        elif solver.startswith("FRICTION_2D"):
            reply = friction(W, q, mu, 2, kind)
        else:
            reply = friction(*(raised(W, q) if len(q) == 2 * len(mu) else (W, q)), mu, 3, kind)
        replies.write(json.dumps(reply) + "\n")


main()
