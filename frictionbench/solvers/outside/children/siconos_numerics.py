"""Siconos in a process of its own, for solvers.outside.siconos: Debian builds it for the system's Python only.

A message is a problem and how to solve it. The clock is around Siconos' problem object, of dense matrices, and the driver.
"""

from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn
from child import Array, serve  # this folder is on the path of the child

CALLS = 3  # of the driver at most: |r| grows little from one answer to the next


def answer(
    kind: str,
    solver: str,
    integers: dict[str, int],
    reals: dict[str, float],
    eps: float,
    size: float,
    limit: int,
    start: Array,
    **given: Array,
) -> dict[str, Any]:
    """Solve a problem from `start`: the answer, the return code of the last call, the iterations and seconds of all calls.

    Siconos divides its error by |q| or, in friction problems, by |r| if that is larger, which is known only afterwards: the
    driver is then called again from its own answer with a smaller tolerance. eps: the error before that division. size: |q|.
    """
    r, iterations = start.copy(), 0
    matrices = (compressed(given, "M"), compressed(given, "H")) if kind == "global" else ()
    begun = perf_counter()
    problem = problem_object(kind, given, *matrices)
    seconds = perf_counter() - begun
    for _ in range(CALLS):
        begun = perf_counter()
        options = sn.SolverOptions(getattr(sn, f"SICONOS_{solver.upper()}"))
        options.dparam[sn.SICONOS_DPARAM_TOL] = eps / size
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = limit
        for name, whole in integers.items():
            options.iparam[getattr(sn, name)] = whole
        for name, real in reals.items():
            options.dparam[getattr(sn, name)] = real
        driver, arguments = call(kind, problem, given, r)
        code = driver(*arguments, options)
        seconds += perf_counter() - begun
        iterations += max(int(options.iparam[sn.SICONOS_IPARAM_ITER_DONE]), 0)
        larger = float(np.linalg.norm(r))
        if code or kind == "lcp" or not larger > size:
            break
        size = 1.1 * larger
    return {"r": r, "code": int(code), "iterations": iterations, "clock": seconds}


def problem_object(kind: str, given: dict[str, Array], *matrices: Any) -> Any:
    """Siconos' problem object, dense except in the global form."""
    if kind == "lcp":
        return sn.LCP(given["M"], given["q"])
    if kind == "global":
        problem = sn.GlobalFrictionContactProblem()
        problem.dimension, problem.numberOfContacts = 3, len(given["mu"])
        problem.M, problem.H = matrices
        problem.q, problem.b, problem.mu = given["q"], given["b"], given["mu"]
        return problem
    dimension = 2 if kind == "friction_2d" else 3
    return sn.FrictionContactProblem(dimension, len(given["mu"]), given["W"], given["q"], given["mu"])


def compressed(given: dict[str, Array], name: str) -> Any:
    """A matrix of entries (row, column, value) in Siconos' sparse storage; this Python may have no scipy."""
    entries = given[name]
    size = (len(given["q"]), len(given["q"]) if name == "M" else len(given["b"]))
    matrix = sn.NM_create(sn.NM_SPARSE, *size)
    sn.NM_triplet_alloc(matrix, len(entries))
    for i, j, value in entries.tolist():
        sn.NM_entry(matrix, int(i), int(j), value)
    return matrix


def call(kind: str, problem: Any, given: dict[str, Array], r: Array) -> tuple[Any, tuple[Any, ...]]:
    """The driver of a problem and its arguments; r is the guess and is overwritten by the answer."""
    if kind == "lcp":
        return sn.linearComplementarity_driver, (problem, r, np.zeros(len(r)))
    if kind == "global":
        return sn.gfc3d_driver, (problem, r, np.zeros(len(r)), np.zeros(len(given["q"])))
    return sn.fc2d_driver if kind == "friction_2d" else sn.fc3d_driver, (problem, r, given["W"] @ r + given["q"])


serve(answer)
