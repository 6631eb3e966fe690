"""Stopping criteria shared by the iterative methods; without a deadline they depend on counts alone, so that runs are
reproducible."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.solvers.clock import deadline, late
from frictionbench.solvers.interface import Answer, Status

ENDS = (Status.SOLVED, Status.BREAKDOWN, Status.STALLED, Status.WORK_LIMIT)


class Monitor(NamedTuple):
    """The stopping criteria of a method, and the record of its convergence.

    tol: the requested residual. limit, patience: in the method's own unit of work, the largest count and the count within which
    the residual must fall to `share`. history: the residuals so far. best (2,): the least of them and its count.
    state (2,): the number of residuals, and the index in ENDS of how the method ended. until: the deadline (solvers.clock).
    """

    tol: float
    limit: int
    patience: int
    share: float
    history: Array
    best: Array
    state: NDArray[np.int64]
    until: float

    @property
    def seen(self) -> int:
        return int(self.state[0])

    def answer(self, r: Array, **work: int) -> Answer:
        return Answer(np.asarray(r, float), ENDS[self.state[1]], work, tuple(self.history[: self.seen].tolist()))


def monitor(tol: float, limit: int, patience: int, every: int = 1, share: float = 0.99) -> Monitor:
    """A monitor of a method that computes its residual after every so many units of work."""
    records = np.empty(2 + limit // every), np.array([np.inf, 0.0]), np.zeros(2, np.int64)
    return Monitor(tol, limit, patience, share, *records, deadline())


@kernel
def should_continue(monitor, error, count):  # type: ignore[no-untyped-def]
    """Record the residual `error` after `count` units of work; return whether to continue.

    Otherwise the monitor holds how the method ended: solved within the tolerance, breakdown if the residual is not finite,
    stalled without progress, or at the limit of work or time.
    """
    monitor.history[monitor.state[0]] = error
    monitor.state[0] += 1
    if error <= monitor.tol:
        monitor.state[1] = 0
        return False
    if not np.isfinite(error):
        monitor.state[1] = 1
        return False
    if error < monitor.share * monitor.best[0]:
        monitor.best[0], monitor.best[1] = error, count
    if count - monitor.best[1] >= monitor.patience:
        monitor.state[1] = 2
        return False
    monitor.state[1] = 3
    return count < monitor.limit and not late(monitor.until)
