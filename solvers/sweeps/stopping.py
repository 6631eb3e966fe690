"""When an iterative method ends, the same for all of them, and by counts alone so that every run ends alike."""

import numpy as np
from numba import njit

from problems.check import Array
from solvers.interface import Status

ENDS = (Status.SOLVED, Status.BREAKDOWN, Status.STALLED, Status.WORK_LIMIT)
GOING = -1


def progress() -> Array:
    """The least error so far and the count at which it was reached."""
    return np.array([np.inf, 0.0])


@njit(cache=True)
def ended(error, tol, count, limit, patience, best):  # type: ignore[no-untyped-def]
    """The index in ENDS of how the method ended, or GOING.

    Solved where error <= tol; broken down where it is not finite; stalled where it has not fallen by a hundredth in
    `patience` counts; at the limit where count >= limit. `best` is progress(), kept up to date here.
    """
    if error <= tol:
        return 0
    if not np.isfinite(error):
        return 1
    if error < 0.99 * best[0]:
        best[0], best[1] = error, count
    if count - best[1] >= patience:
        return 2
    return 3 if count >= limit else GOING
