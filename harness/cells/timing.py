"""Timing of form, setup and solve, apart, on the same problem met afresh each time.

A call in which anything was compiled or loaded (numba compiling or reading its cache, Python importing a module) is never a
sample: it is made again, and a solver of which no call is without has no times. The first call answers. Where it was short its
times are not kept either, for it also warmed caches, and repeats follow until a budget is spent: at least three, at most
fifteen. A long call is its own measurement. Garbage collection rests meanwhile. Times are raw, in seconds. Answers are copied
as they come, so that each that was timed can be verified.
"""

import gc
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter  # held here: a solver may replace what `time` holds
from typing import Any, NamedTuple

from frictionbench.harness.cells.answers import alike, plain
from frictionbench.harness.process import no_forked_child
from frictionbench.problems import LCP, FrictionProblem
from frictionbench.solvers import Answer, Solver

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
    """Raw times of the kept repeats, in order; of the first call, unless it loaded something; and of all calls: in seconds.

    clock: the library's own of the kept repeats, where it has one.
    answers: of the first call and of those that were kept, each that is unlike the others.
    """

    form: list[float] = field(default_factory=list)
    setup: list[float] = field(default_factory=list)
    solve: list[float] = field(default_factory=list)
    first: float | None = None
    clock: list[float] = field(default_factory=list)
    spent: float = 0.0
    answers: list[Answer] = field(default_factory=list)

    def note(self, answer: Answer) -> None:
        if not any(alike(answer, known) for known in self.answers):
            self.answers.append(answer)

    def keep(self, call: Call) -> None:
        self.note(call.answer)
        if not call.loaded:
            for samples, seconds in zip((self.form, self.setup, self.solve), call.times, strict=True):
                samples.append(seconds)
            if call.answer.clock is not None:
                self.clock.append(call.answer.clock)


def time_solver(
    solver: Solver,
    problem: FrictionProblem | LCP,
    solve: Callable[[Any], Answer],
    answered: Callable[[], None],
    most: int = MOST,
) -> Timing:
    """The answers to the problem, and the times; answered() is called between the first and the repeats.

    solve: the solver's, with the tolerance and the start. most: repeats at the most. Errors: AnswerError, and whatever the
    solver raises.
    """
    timing = Timing()
    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        first = _timed(solver, problem, solve, timing)
        timing.note(first.answer)
        timing.first = None if first.loaded else sum(first.times)
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
    return timing


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
    with (
        event.install_recorder("numba:compiler_lock") as loads,
        no_forked_child(),
    ):  # held to compile and to read from the cache
        start = perf_counter()
        formed = solver.form(met)
        written = perf_counter()
        prepared = solver.setup(formed)
        ready = perf_counter()
        answer = solve(prepared)
        end = perf_counter()
    return Call(
        plain(answer), (written - start, ready - written, end - ready), bool(loads.buffer) or len(sys.modules) != modules
    )


def _timed(solver: Solver, problem: FrictionProblem | LCP, solve: Callable[[Any], Answer], timing: Timing) -> Call:
    made = timed_call(solver, problem, solve)
    timing.spent += sum(made.times)
    return made
