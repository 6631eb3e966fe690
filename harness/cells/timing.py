"""Timing of prepare and solve, apart, on the same problem met afresh each time.

The first call answers. Where it was short its times are not kept, for it also warmed caches and loaded code, and repeats
follow until a budget is spent: at least three, at most fifteen. A long call is its own measurement, unless numba compiled
something in it; then it is made once more. Garbage collection rests meanwhile. Times are raw, in seconds.
"""

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from solvers import Answer

BUDGET = 0.1  # seconds of repeats a cell
FEWEST, MOST = 3, 15


@dataclass
class Timing:
    """Raw times of the kept repeats, in order, and all the time inside prepare and solve, in seconds."""

    prepare: list[float] = field(default_factory=list)
    solve: list[float] = field(default_factory=list)
    spent: float = 0.0

    def keep(self, times: tuple[float, float]) -> None:
        self.prepare.append(times[0])
        self.solve.append(times[1])
        self.spent += sum(times)


def time_solver(
    meet: Callable[[], Any], prepare: Callable[[Any], Any], solve: Callable[[Any], Answer], answered: Callable[[], None]
) -> tuple[Answer, Timing]:
    """The first answer to the problem that meet() gives, and the times; answered() is called between it and the repeats."""
    from numba.core import event

    timing = Timing()
    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        with event.install_recorder("numba:compile") as compiled:
            answer, first = _once(meet, prepare, solve)
        answered()
        spent = sum(first)
        if spent > BUDGET and not compiled.buffer:
            timing.keep(first)
        elif spent > BUDGET:
            timing.spent = spent
            timing.keep(_once(meet, prepare, solve)[1])
        else:
            timing.spent = spent
            for _ in range(max(FEWEST, min(MOST, int(BUDGET / max(spent, 1e-9))))):
                timing.keep(_once(meet, prepare, solve)[1])
    finally:
        if enabled:
            gc.enable()
    return answer, timing


def _once(
    meet: Callable[[], Any], prepare: Callable[[Any], Any], solve: Callable[[Any], Answer]
) -> tuple[Answer, tuple[float, float]]:
    problem = meet()
    start = time.perf_counter()
    prepared = prepare(problem)
    middle = time.perf_counter()
    answer = solve(prepared)
    end = time.perf_counter()
    return answer, (middle - start, end - middle)
