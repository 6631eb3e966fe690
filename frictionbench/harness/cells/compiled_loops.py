"""QuantEcon's kernel called from compiled code, in the two ways `kernel` and `kernel from bodies` of batches.

The first is the loop that its author would write: dense matrices are made beforehand, and neither that nor a residual is in its
time. The second puts the kernel in the place of ours, between our form of the bodies and the residuals of the impulses, so that
kernels alone differ. A loop returns an answer for each problem, made after the timed call.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from frictionbench.problems.batch import Batch
from frictionbench.problems.check import Array
from frictionbench.problems.forms.lcp import tangent_basis
from frictionbench.problems.packed import residuals
from frictionbench.solvers import Answer, Status, find
from frictionbench.solvers.loops import impulses_of
from frictionbench.solvers.outside.quantecon import ENDED, kernel_of
from frictionbench.solvers.pivots.dense_lcp import dense_lcp
from frictionbench.solvers.pivots.packed_lcp import lcp_space, scaled_lcp_of, write_stretched

MOST_PIVOTS = 100_000
FACETS = 8  # of the polygon in space


class Way(NamedTuple):
    """run solves all problems of a batch, and is what is timed; answers makes an answer to each of what it returned."""

    run: Callable[[], Any]
    answers: Callable[[Any], Iterable[Answer]] = iter


def kernel(batch: Batch, spec: str) -> Way:
    """The loop over dense matrices that are made here."""
    forms = [dense_lcp(problem, FACETS) for problem in batch]
    size = np.array([len(form.q) for form in forms])
    first, square = np.concatenate([[0], size.cumsum()]), np.concatenate([[0], (size**2).cumsum()])
    M, q = np.concatenate([form.M.ravel() for form in forms]), np.concatenate([form.q for form in forms])

    def answers(found: tuple[Array, Array]) -> Iterator[Answer]:
        z, ended = found
        for k, form in enumerate(forms):
            yield form.answer(z[first[k] : first[k + 1]], ENDED.get(int(ended[k, 0]), Status.FAILED), pivots=int(ended[k, 1]))

    return Way(partial(_kernel_loop(_settings(spec)), first, square, M, q), answers)


def kernel_from_bodies(batch: Batch, spec: str) -> Way:
    """The loop with form and residuals."""
    ((_, packed),), basis = batch.groups, tangent_basis(batch.problems[0].dimension, FACETS)
    most = (len(basis[0]) + 1) * int(np.diff(packed.contacts).max())
    room = np.empty(most**2), np.empty(most * (2 * most + 2)), np.empty(most, np.int_), np.empty(most)
    loop = _loop_from_bodies(_settings(spec))

    def run() -> tuple[Array, Array]:
        r = np.empty((int(packed.contacts[-1]), packed.dimension))
        ended = loop(packed, basis, lcp_space(packed, basis), *room, r)
        residuals(packed, r)
        return r, ended

    def answers(found: tuple[Array, Array]) -> Iterator[Answer]:
        r, ended = found
        for k, (begin, end) in enumerate(pairwise(packed.contacts)):
            yield Answer(r[begin:end], ENDED.get(int(ended[k, 0]), Status.FAILED), {"pivots": int(ended[k, 1])})

    return Way(run, answers)


def _settings(spec: str) -> str:
    instance: Any = find(spec)[1]
    return str(instance.settings)


@cache
def _kernel_loop(settings: str) -> Callable[..., Any]:
    lemke, options = kernel_of(settings)

    @njit(nogil=True)
    def loop(first, square, M, q):  # type: ignore[no-untyped-def]
        z, ended = np.empty(len(q)), np.empty((len(first) - 1, 2), np.int64)
        for k in range(len(first) - 1):
            n = first[k + 1] - first[k]
            dense = M[square[k] : square[k + 1]].reshape(n, n)
            found = lemke(dense, q[first[k] : first[k + 1]], None, MOST_PIVOTS, options)
            z[first[k] : first[k + 1]] = found.z
            ended[k, 0], ended[k, 1] = found.status, found.num_iter
        return z, ended

    return loop


@cache
def _loop_from_bodies(settings: str) -> Callable[..., Any]:
    lemke, options = kernel_of(settings)

    @njit(nogil=True)
    def loop(packed, basis, lcp, M, tableau, places, z, r):  # type: ignore[no-untyped-def]
        ended = np.empty((len(packed.first) - 1, 2), np.int64)
        for k in range(len(ended)):
            _, stretch, columns, q, _ = scaled_lcp_of(packed, k, basis, lcp)
            n = len(q)
            dense, y = M[: n * n].reshape(n, n), z[:n]
            dense[:] = 0.0
            for j in range(n):
                for e in range(columns.start[j], columns.start[j + 1]):
                    dense[columns.rows[e], j] = columns.column[e]
            own = tableau[: n * (2 * n + 2)].reshape(n, 2 * n + 2)
            found = lemke(dense, q, None, MOST_PIVOTS, options, own, places[:n], y)
            ended[k, 0], ended[k, 1] = found.status, found.num_iter
            write_stretched(basis, y, stretch, impulses_of(packed, k, r))
        return ended

    return loop


LOOPS: dict[str, Callable[[Batch, str], Way]] = {"kernel": kernel, "kernel from bodies": kernel_from_bodies}
