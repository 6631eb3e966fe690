"""Timing of form, setup and solve, apart, on the same problem met afresh each time.

A call in which anything was compiled or loaded (numba compiling or reading its cache, Python importing a module) is never a
sample: it is made again, and a solver of which no call is without has no times. The first call answers. Where it was short its
times are not kept either, for it also warmed caches, and repeats follow until a budget is spent: at least three, at most
fifteen. A long call is its own measurement. Garbage collection rests meanwhile. Times are raw, in seconds.
"""

import gc
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from problems import LCP, FrictionProblem
from solvers import Answer, Solver

BUDGET = 0.1  # seconds of repeats a cell
FEWEST, MOST = 3, 15
LOADS = 5  # calls in a row that load something: so will the next


class Call(NamedTuple):
    """One call's answer; seconds in form, setup and solve; whether anything was compiled or loaded in it."""

    answer: Answer
    times: tuple[float, float, float]
    loaded: bool


@dataclass
class Timing:
    """Raw times of the kept repeats, in order, and all the time inside the three steps, in seconds."""

    form: list[float] = field(default_factory=list)
    setup: list[float] = field(default_factory=list)
    solve: list[float] = field(default_factory=list)
    spent: float = 0.0

    def keep(self, call: Call) -> None:
        if not call.loaded:
            for samples, seconds in zip((self.form, self.setup, self.solve), call.times, strict=True):
                samples.append(seconds)


def time_solver(
    solver: Solver,
    problem: FrictionProblem | LCP,
    solve: Callable[[Any], Answer],
    answered: Callable[[], None],
    most: int = MOST,
) -> tuple[Answer, Timing]:
    """The first answer to the problem, and the times; answered() is called between it and the repeats.

    solve: the solver's, with the tolerance and the start. most: repeats at the most.
    """
    timing = Timing()
    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        first = _timed(solver, problem, solve, timing)
        answered()
        clean = first if not first.loaded else clean_call(lambda: _timed(solver, problem, solve, timing))
        seconds = sum(clean.times)
        if seconds > BUDGET:
            timing.keep(clean)
        else:
            for _ in range(max(min(FEWEST, most), min(most, int(BUDGET / max(seconds, 1e-9))))):
                timing.keep(clean_call(lambda: _timed(solver, problem, solve, timing)))
    finally:
        if enabled:
            gc.enable()
    return first.answer, timing


def clean_call(call: Callable[[], Call]) -> Call:
    """The first call in which nothing was compiled or loaded; the last one, if every one of LOADS loads something."""
    for _ in range(LOADS):
        made = call()
        if not made.loaded:
            break
    return made


def timed_call(solver: Solver, problem: FrictionProblem | LCP, solve: Callable[[Any], Answer]) -> Call:
    """One call on the problem met afresh."""
    from numba.core import event

    met, modules = problem.fresh(), len(sys.modules)
    with event.install_recorder("numba:compiler_lock") as loads:  # held to compile and to read from the cache
        start = time.perf_counter()
        formed = solver.form(met)
        written = time.perf_counter()
        prepared = solver.setup(formed)
        ready = time.perf_counter()
        answer = solve(prepared)
        end = time.perf_counter()
    return Call(answer, (written - start, ready - written, end - ready), bool(loads.buffer) or len(sys.modules) != modules)


def _timed(solver: Solver, problem: FrictionProblem | LCP, solve: Callable[[Any], Answer], timing: Timing) -> Call:
    made = timed_call(solver, problem, solve)
    timing.spent += sum(made.times)
    return made
