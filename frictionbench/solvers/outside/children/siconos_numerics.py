"""Siconos in a process of its own, for solvers.outside.siconos: Debian builds it for the system's Python only.

The clock measures Siconos' problem object and driver, for matrices in the storage of its simulations (W in blocks, the global
form in compressed columns); options and a guess of the velocities are prepared before. Siconos' Python module makes block
matrices only from scipy's, which this Python may not have; its library is therefore called directly for that.
"""

import ctypes
from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn
from child import Array, serve  # this folder is on the path of the child

_NUMERICS = ctypes.CDLL(sn._numerics.__file__)  # and the library behind it
_NUMERICS.NM_csc.restype, _NUMERICS.NM_csc.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
_NUMERICS.SBM_from_csparse.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p]
CALLS = 3  # the largest number of calls of the driver: |r| grows little from one answer to the next
SHORT = 1e-3  # s: shorter solves are repeated, as a process that waited for a message begins with cold caches


def answer(**message: Any) -> dict[str, Any]:
    """The reply to a message: the result of `solved`, for short solves that of the third in a row."""
    found = solved(**message)
    for _ in range(2):
        found = solved(**message) if found["clock"] < SHORT else found
    return found


def solved(
    kind: str,
    solver: str,
    integers: dict[str, int],
    reals: dict[str, float],
    local: str,
    eps: float,
    size: float,
    limit: int,
    start: Array,
    dense: bool = True,
    **data: Array,
) -> dict[str, Any]:
    """Solve a problem from `start`: the answer, the return code of the last call, whether the driver states an error above the
    tolerance whatever its code (friction_2d), the iterations and seconds of all calls.

    Siconos divides its error by |q| or, in friction problems, by |r| if that is larger, which is known only afterwards. The
    driver is then called again from its own answer with a smaller tolerance, unless this answer is accurate enough: from such
    an answer PROX makes no step and reports failure. eps: the requested error before the division. size: |q|. dense: whether W
    is a dense matrix, otherwise its entries.
    """
    r, iterations = start.copy(), 0
    matrices: tuple[Any, ...]
    if kind == "global":
        matrices = compressed(data["M"], len(data["q"]), len(data["q"])), compressed(data["H"], len(data["q"]), len(r))
    elif kind == "lcp":
        matrices = (data["M"],)
    else:
        matrices = (data["W"] if dense else blocks(data["W"], len(r), len(r) // len(data["mu"])),)
    begun = perf_counter()
    problem = problem_object(kind, data, *matrices)
    seconds = perf_counter() - begun
    for _ in range(CALLS):
        options = sn.SolverOptions(getattr(sn, f"SICONOS_{solver.upper()}"))
        options.dparam[sn.SICONOS_DPARAM_TOL] = eps / size
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = limit
        for name, whole in integers.items():
            options.iparam[getattr(sn, name)] = whole
        for name, real in reals.items():
            options.dparam[getattr(sn, name)] = real
        if local:
            sn.solver_options_update_internal(options, 0, getattr(sn, f"SICONOS_{local}"))
        driver, arguments = call(kind, problem, data, dense, r)
        begun = perf_counter()
        code = driver(*arguments, options)
        seconds += perf_counter() - begun
        iterations += max(int(options.iparam[sn.SICONOS_IPARAM_ITER_DONE]), 0)
        larger, error = float(np.linalg.norm(r)), options.dparam[sn.SICONOS_DPARAM_RESIDU]
        if code or kind == "lcp" or not larger > size or error * larger <= eps:
            break
        size = 1.1 * larger
    unsaid = kind == "friction_2d" and not error * size <= eps
    return {"r": r, "code": int(code), "unsaid": bool(unsaid), "iterations": iterations, "clock": seconds}


def problem_object(kind: str, data: dict[str, Array], *matrices: Any) -> Any:
    """Siconos' problem object."""
    if kind == "lcp":
        return sn.LCP(*matrices, data["q"])
    if kind == "global":
        problem = sn.GlobalFrictionContactProblem()
        problem.dimension, problem.numberOfContacts = 3, len(data["mu"])
        problem.M, problem.H = matrices
        problem.q, problem.b, problem.mu = data["q"], data["b"], data["mu"]
        return problem
    return sn.FrictionContactProblem(2 if kind == "friction_2d" else 3, len(data["mu"]), *matrices, data["q"], data["mu"])


def compressed(entries: Array, rows: int, columns: int) -> Any:
    """A matrix of entries (row, column, value) in Siconos' sparse storage."""
    matrix = sn.NM_create(sn.NM_SPARSE, rows, columns)
    sn.NM_triplet_alloc(matrix, len(entries))
    for i, j, value in entries.tolist():
        sn.NM_entry(matrix, int(i), int(j), value)
    return matrix


def blocks(entries: Array, n: int, size: int) -> Any:
    """A square matrix of entries in Siconos' block storage, with blocks of `size` rows and columns."""
    sparse, matrix = compressed(entries, n, n), sn.NM_create(sn.NM_SPARSE_BLOCK, n, n)
    if _NUMERICS.SBM_from_csparse(size, _NUMERICS.NM_csc(int(sparse.this)), int(matrix.matrix1.this)):
        raise RuntimeError("Siconos made no blocks of the matrix")
    return matrix


def call(kind: str, problem: Any, data: dict[str, Array], dense: bool, r: Array) -> tuple[Any, tuple[Any, ...]]:
    """The driver of a problem and its arguments; r is the guess and is overwritten by the answer."""
    if kind == "lcp":
        return sn.linearComplementarity_driver, (problem, r, np.zeros(len(r)))
    if kind == "global":
        return sn.gfc3d_driver, (problem, r, np.zeros(len(r)), np.zeros(len(data["q"])))
    W, u = data["W"], data["q"].copy()
    u += W @ r if dense else np.bincount(W[:, 0].astype(int), W[:, 2] * r[W[:, 1].astype(int)], len(r))
    return sn.fc2d_driver if kind == "friction_2d" else sn.fc3d_driver, (problem, r, u)


serve(answer)
