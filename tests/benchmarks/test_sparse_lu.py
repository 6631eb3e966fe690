"""The sparse LU beside scipy's splu, and with its vector instructions left out.

The matrices are Newton's of the interior point in its sixth iteration, as the predictor-corrector meets them. In the group
of a matrix the rows are

    ours           factorise, the order of elimination found beforehand by `analyse`,
    plain          the same with plain loops in place of the vector instructions of sparse_lu.vectors in wide fronts,
    COLAMD, ...    splu with this ordering, which it computes each time,
    NATURAL        splu in our order of elimination, so that it computes none.

An interior point method factorises some ten to a thousand matrices of one pattern, for which splu would compute its ordering
each time. The best of splu is the smallest of its rows.

Measured: docs/architecture.md.
"""

from functools import cache
from types import FunctionType

import numpy as np
import pytest
from numba import njit
from scipy import sparse
from scipy.sparse.linalg import splu

from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.instances.spheres import sphere_pyramid
from frictionbench.solvers.interior.newton import NEWTON_PIVOT, new_work
from frictionbench.solvers.interior.point import start_point
from frictionbench.solvers.interior.predictor_corrector import nothing_yet, predictor_corrector
from frictionbench.solvers.interior.system import build_system, space_of
from frictionbench.solvers.sparse_lu import multifrontal
from tests.helpers.kernels import assemble, solve_factorised

MATRICES = {
    "stack of 50": lambda: scene("stack", blocks=50).problem(),
    "stack of 1000": lambda: scene("stack", blocks=1000).problem(),
    "pyramid of 15 rows": lambda: scene("pyramid", rows=15).problem(),
    "pyramid of 40 rows": lambda: scene("pyramid", rows=40).problem(),
    "250 cubes": lambda: cubes(250),
    "pyramid of spheres, 6 levels": lambda: sphere_pyramid(levels=6),
    "pyramid of spheres, 10 levels": lambda: sphere_pyramid(levels=10),
}
ORDERINGS = ("COLAMD", "MMD_AT_PLUS_A", "MMD_ATA", "NATURAL")
SYMMETRIC = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}  # as the pattern is, and with the least fill
NEVER = 10**9


@cache
def matrix(name: str):
    """The system, its fronts as assembled, and the matrix by columns."""
    system = build_system(MATRICES[name]())
    space, work, point = space_of(system), new_work(system, np.inf), start_point(system, 1.0, 1.0)
    best = nothing_yet(*system.offset.shape)
    predictor_corrector(system, space, point, work, best, 0.0, 12, np.empty(5))
    assemble(system, space, point, work)
    fronts, storage = system.fronts, work.storage
    rows, columns = [], []
    for f in range(len(fronts.pivots)):
        variable = fronts.variable[fronts.first[f] : fronts.first[f + 1]]
        rows.append(np.repeat(variable, len(variable)))
        columns.append(np.tile(variable, len(variable)))
    place = np.concatenate(rows).astype(np.int32), np.concatenate(columns).astype(np.int32)
    A = sparse.csc_matrix(sparse.coo_matrix((storage, place)))
    A.eliminate_zeros()
    return system, storage.copy(), A


@cache
def plain():
    """factorise, compiled to take every front as a narrow one."""
    function = multifrontal.factorise.py_func
    return njit(error_model="numpy")(FunctionType(function.__code__, vars(multifrontal) | {"NARROW": NEVER}))


@pytest.mark.parametrize("method", ["ours", "plain", *ORDERINGS])
@pytest.mark.parametrize("name", MATRICES)
def test_newton_matrix(benchmark, name, method) -> None:
    benchmark.group = name
    system, assembled, A = matrix(name)
    b = np.ones(A.shape[0])
    benchmark.extra_info.update(variables=A.shape[0], entries=A.nnz)
    if method in ORDERINGS:
        options = SYMMETRIC if method in ("MMD_AT_PLUS_A", "NATURAL") else {}
        lu = benchmark.pedantic(splu, args=(A, method), kwargs=options, rounds=20)
        x, fill = lu.solve(b), lu.L.nnz + lu.U.nnz
    else:
        factorise = plain() if method == "plain" else multifrontal.factorise
        storage, swap, x, fill = np.empty_like(assembled), np.zeros(len(b), np.int64), b.copy(), len(assembled)

        def again():
            storage[:] = assembled
            return (system.fronts, storage, swap, NEWTON_PIVOT), {}

        benchmark.pedantic(factorise, setup=again, rounds=20, warmup_rounds=1)
        solve_factorised(system.fronts, storage, swap, x)
    benchmark.extra_info["fill"] = fill
    assert np.abs(A @ x - b).max() <= 1e-6 * np.abs(A).max() * np.abs(x).max()
