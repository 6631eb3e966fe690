"""Solvers that misbehave in different ways. A run must give their cells the right verdict and leave all others unaffected."""

import ctypes
import os
import signal
import sys
import time
from functools import wraps

import numpy as np
from numba import njit

import frictionbench.solvers.lemke
from frictionbench.solvers import Answer, Status, solve, solver


def answer(problem, impulse=None):
    return Answer(np.zeros((problem.contacts, problem.dimension)) if impulse is None else impulse, Status.SOLVED)


def bad(misbehave, family="bad"):
    """List a solver that answers as the function of the problem does, under the function's name."""

    class Misbehaving:
        __doc__ = misbehave.__doc__

        def solve(self, problem, tol, limit, start=None):
            # The harness first warms every solver up on a single contact, for which these answer correctly.
            return answer(problem) if problem.contacts == 1 else misbehave(problem)

    return solver(misbehave.__name__, family=family, model="coulomb")(Misbehaving)


def changed(change=None, family="bad"):
    """List a solver that solves the problem, and then changes its answer by the function."""
    if change is None:
        return lambda change: changed(change, family)

    @wraps(change)
    def misbehave(problem):
        answer = solve(problem, "lemke")
        change(answer)
        return answer

    return bad(misbehave, family)


@bad
def segfault(problem):
    """Reads address zero."""
    ctypes.string_at(0)


@bad
def calls_os_exit(problem):
    """Ends the process with exit code 0."""
    os._exit(0)


@njit
def spin():
    x = 1.0
    while x > 0:
        x = x * 1.0000001 if x < 1e9 else 1.0
    return x


@bad
def exhausts_memory(problem):
    """Allocates memory until the limit is reached."""
    arrays = []
    while True:
        arrays.append(np.empty(2**24))


@bad
def wrong_zero(problem):
    """Returns zero impulses with status SOLVED."""
    return answer(problem)


@bad
def nan_impulse(problem):
    """Returns NaN impulses with status SOLVED."""
    return answer(problem, np.full((problem.contacts, 2), np.nan))


@bad
def modifies_friction(problem):
    """Sets the friction coefficients of its input to zero."""
    problem.friction.setflags(write=True)
    problem.friction[:] = 0
    return answer(problem)


@bad
def reports_stalled(problem):
    """Reports STALLED."""
    return Answer(np.zeros((problem.contacts, 2)), Status.STALLED)


@bad
def blocks_signals(problem):
    """Blocks every signal, disarms the timers, and loops for ever in native code."""
    signal.pthread_sigmask(signal.SIG_SETMASK, set(signal.Signals))
    for timer in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF):
        signal.setitimer(timer, 0)
    spin()


@solver("hangs_in_warm_up", family="bad", model="coulomb")
class HangsInWarmUp:
    """Loops for ever in every call, from the warm-up on."""

    def solve(self, problem, tol, limit, start=None):
        spin()


@bad
def forks(problem):
    """Forks and returns in both the parent and the child process."""
    os.fork()
    return answer(problem)


@bad
def daemonises_child(problem):
    """Leaves an orphaned process in a session of its own, which loops for ever and holds the worker's pipes open."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            spin()
        os._exit(0)
    return answer(problem)


@bad
def freezes_clocks(problem):
    """Replaces the clocks of Python's time module by constants."""
    time.perf_counter = time.monotonic = time.time = lambda: 0.0
    return solve(problem, "lemke")


@bad
def patches_lemke(problem):
    """Replaces the solve method of lemke in this process by one that returns None."""
    frictionbench.solvers.lemke.Lemke.solve = lambda self, prepared, tol, limit, start=None: None
    return answer(problem)


@bad
def modifies_mass(problem):
    """Multiplies the inverse mass matrix by 100, which does not enter the problem's hash, and solves the changed problem."""
    problem.inverse_rows.value[:] *= 100
    return Answer(solve(problem.fresh(), "lemke").impulse, Status.SOLVED)


def repeated(what) -> bool:
    """Whether this has been asked with the same argument before."""
    before = what in _seen
    _seen.add(what)
    return before


_seen: set[object] = set()


@bad
def caches_result(problem):
    """Takes 20 ms for the first problem of each size and returns at once afterwards, always STALLED."""
    end = time.perf_counter() + (0 if repeated(("size", problem.contacts)) else 0.02)
    while time.perf_counter() < end:
        pass
    return Answer(np.zeros((problem.contacts, 2)), Status.STALLED)


@bad
def zero_on_repeat(problem):
    """Solves each problem once, and returns zeros at once for repeats."""
    return answer(problem) if repeated(("zero", problem.hash)) else solve(problem, "lemke")


@bad
def hangs_on_repeat(problem):
    """Solves each problem once, and hangs on repeats."""
    return spin() if repeated(("hang", problem.hash)) else solve(problem, "lemke")


@changed
def slow_impulse(answer):
    """Returns an object whose conversion to an array never ends."""
    answer.impulse = type("Slow", (), {"__array__": lambda self, *_, **__: spin()})()


@changed(family="good")
def long_detail(answer):
    """Solves the problem and returns ten megabytes of unprintable characters as detail."""
    answer.detail = "\ud800\0" * 5_000_000


@bad
def calls_sys_exit(problem):
    """Calls sys.exit."""
    sys.exit(3)


@bad
def writes_to_fds(problem):
    """Writes random bytes to all open file descriptors."""
    for number in map(int, os.listdir("/proc/self/fd")):
        try:
            os.set_blocking(number, False)
            os.write(number, b"\0\1\2 rubbish \n" * 1000)
        except OSError:
            continue
    return answer(problem)
