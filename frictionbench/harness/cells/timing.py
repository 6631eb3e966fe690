"""Timing of form, setup and solve separately, on copies of one problem without cached values.

A call in which anything was compiled or loaded (numba compiling or reading its cache, Python importing a module) is never a
sample. It is repeated, and a solver that loads something in every call has no times. The first call gives the answer. If it was
short, its times are discarded, because it also warmed caches, and repeats follow until a budget is spent. A long call is its
own sample. Garbage collection is disabled meanwhile. Answers are copied when they are returned, so that each timed answer can
be verified. An answer that is not plain arrays and numbers is converted within the time of its solve, because the solver may
defer work until it is read, or do it in another thread or on a device.

A library that runs in another process only here is timed by its own clock in that process (SolverInfo.remote). Setup and solve
are then that time, but no more than the call took, and the call's time is stored as well. Form is called once more before it is
timed, because this process has waited for the library and begins with cold caches.

Repeats could be answered from a cache, even unintentionally, by a memoised matrix. So could a first call, if the solver met the
problem in an earlier cell or process. A last call is therefore made on a problem that differs in the last bits, by a random
number of units, so that no file can hold its answer. If it takes much longer than another call on that problem, or its answer
has a worse verdict, this is repeated with another one. If both are slow, the solver reuses results, and their times are
the samples. Their answers then count too: those to the problem itself may be kept from a version that was right.
"""

import gc
import secrets
import statistics
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from time import perf_counter  # bound here: a solver may replace the attributes of `time`
from typing import Any, NamedTuple

from frictionbench.harness.process import no_forked_child, waited
from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.answer import bits, checked_copy, is_plain
from frictionbench.problems.copies import nudged
from frictionbench.solvers import Answer, Solver

BUDGET = 0.1  # seconds of repeats per cell: suites have thousands of cells
FEWEST_REPEATS, MOST_REPEATS = 3, 15  # repeats: a median needs three, and more than fifteen change it little
SLOW_FIRST = 5.0  # ratio of a first call to the repeats above which its results may have been reused
SLOW_NEW = 2e-4  # seconds: a shorter call on a new problem is not suspect, because interruptions take as long
MOST_ULPS = 4096  # largest nudge: a relative change of at most 1e-12, and enough values that one is rarely drawn twice
LOADS = 5  # successive calls that load something, after which the next is expected to do so as well


class Call(NamedTuple):
    """One call: its answer, the seconds of form, setup and solve, whether anything was compiled or loaded, the seconds for
    which it waited for a core, and those of setup and solve with the transfer to another process."""

    answer: Answer
    times: tuple[float, float, float]
    loaded: bool
    waited: float
    transferred: float

    @property
    def running(self) -> float:
        """Seconds without waiting for a core, so that a busy machine does not make a solver suspect."""
        return sum(self.times) - self.waited


@dataclass
class Timing:
    """Raw times in seconds: form, setup and solve of each sample in order.

    first: the first call, None if it loaded something. spent: all calls. clock: the samples' times by the library's own clock,
    if it has one. answers: the distinct answers of the first call and the samples. remote: as above; calls: for each remote
    sample, setup and solve including the transfer. reused: the ratio of the time on a new problem to that of the repeats if the
    solver reuses results, otherwise None; new_answers: such new problems with the answers.
    """

    remote: bool = False
    form: list[float] = field(default_factory=list)
    setup: list[float] = field(default_factory=list)
    solve: list[float] = field(default_factory=list)
    first: float | None = None
    clock: list[float] = field(default_factory=list)
    calls: list[float] = field(default_factory=list)
    spent: float = 0.0
    answers: list[Answer] = field(default_factory=list)
    reused: float | None = None
    new_answers: list[tuple[FrictionProblem | LCP, Answer]] = field(default_factory=list)

    def add_answer(self, answer: Answer) -> None:
        if bits(answer) not in map(bits, self.answers):
            self.answers.append(answer)

    def add_sample(self, call: Call) -> None:
        """Add a call's answer and, unless it loaded something, its times."""
        self.add_answer(call.answer)
        if not call.loaded:
            for samples, seconds in zip((self.form, self.setup, self.solve), call.times, strict=True):
                samples.append(seconds)
            if call.answer.clock is not None:
                self.clock.append(call.answer.clock)
                self.calls += [call.transferred] if self.remote else []


def time_solver(
    solver: Solver,
    problem: FrictionProblem | LCP,
    solve: Callable[[Any], Answer],
    restart_limit: Callable[[], None],
    rank: Callable[[Any, Answer], int],
    most: int = MOST_REPEATS,
    remote: bool = False,
    met_before: bool = False,
) -> Timing:
    """Return the answers to the problem and their times.

    solve: calls the solver with the tolerance and the start. restart_limit: called after each call. rank: of the verdict on an
    answer. most: the largest number of repeats. remote: as in Timing. met_before: whether the solver may have met the problem
    before, so that a long call is tested for reuse as well.
    Errors: AnswerError, and whatever the solver raises.
    """
    timing = Timing(remote)

    def call(given: FrictionProblem | LCP = problem) -> Call:
        made = timed_call(solver, given, solve, remote)
        timing.spent += made.times[0] + made.transferred
        restart_limit()
        return made

    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        first = call()
        timing.add_answer(first.answer)
        timing.first = None if first.loaded else sum(first.times)
        clean = first if not first.loaded else clean_call(call)
        seconds = clean.times[0] + clean.transferred
        if seconds > BUDGET:
            timing.add_sample(clean)
        else:
            for _ in range(max(min(FEWEST_REPEATS, most), min(most, int(BUDGET / max(seconds, 1e-9))))):
                timing.add_sample(clean_call(call))
        if timing.solve and (seconds <= BUDGET or met_before):
            check_reuse(timing, problem, call, rank)
    finally:
        if enabled:
            gc.enable()
    return timing


def drawn_ulps() -> int:
    """Draw a number of units in the last place for `nudged`; it cannot be predicted."""
    return 1 + secrets.randbelow(MOST_ULPS)


def check_reuse(
    timing: Timing, problem: FrictionProblem | LCP, call: Callable[[Any], Call], rank: Callable[[Any, Answer], int]
) -> None:
    """Test whether the solver reuses results, as described above. If so, replace the samples or add the new answers.

    Errors: whatever the solver raises on two new problems."""
    usual, new = statistics.median(map(sum, zip(timing.form, timing.setup, timing.solve, strict=True))), []
    for errors in (Exception,), ():  # one failure alone may be due to rounding
        other = nudged(problem, drawn_ulps())
        with suppress(*errors):
            made = call(other)
            slow = made.running > max(SLOW_FIRST * usual, SLOW_NEW)  # the second call may be the first to read a file
            slow = slow and made.running > SLOW_FIRST * min(call(other).running for _ in range(2))
            if not slow and rank(other, made.answer) <= max(rank(problem, answer) for answer in timing.answers):
                return
            new.append((other, made, slow))
    times, timing.new_answers = [made.times for _, made, slow in new if slow], [(other, made.answer) for other, made, _ in new]
    if len(times) > 1:
        timing.form, timing.setup, timing.solve = map(list, zip(*times, strict=True))
        timing.reused, timing.clock, timing.calls = min(map(sum, times)) / max(usual, 1e-9), [], []


def clean_call(call: Callable[[], Call]) -> Call:
    """Return the first call in which nothing was compiled or loaded, or the last of LOADS calls if each loads something."""
    for _ in range(LOADS):
        made = call()
        if not made.loaded:
            break
    return made


def timed_call(solver: Solver, problem: FrictionProblem | LCP, solve: Callable[[Any], Answer], remote: bool) -> Call:
    """Make one call on the problem, without values cached by earlier calls. remote: as in Timing."""
    from numba.core import event

    fresh, modules = problem.fresh(), len(sys.modules)
    # numba holds this lock while it compiles or reads its cache
    with event.install_recorder("numba:compiler_lock") as loads, no_forked_child():
        if remote:
            solver.form(problem.fresh())
        before = waited()
        start = perf_counter()
        formed = solver.form(fresh)
        written = perf_counter()
        prepared = solver.setup(formed)
        ready = perf_counter()
        answer = solve(prepared)
        end = perf_counter()
        wait = waited() - before
        if not is_plain(answer):
            begun = perf_counter()
            answer = checked_copy(answer)
            end += perf_counter() - begun
    loaded = bool(loads.buffer) or len(sys.modules) != modules
    times, transferred = (written - start, ready - written, end - ready), end - written
    if remote and answer.clock is not None:
        times = times[0], 0.0, min(answer.clock, transferred)
    return Call(checked_copy(answer), times, loaded, wait if wait > 0 else 0.0, transferred)
