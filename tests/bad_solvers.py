"""Solvers that misbehave, each in its own way; each must cost one cell and leave the right row."""

import ctypes
import os
import signal
from functools import cache

import numpy as np
from numba import njit

from solvers import Answer, Status, solver


def answer(problem, impulse=None):
    return Answer(np.zeros((problem.contacts, problem.dimension)) if impulse is None else impulse, Status.SOLVED)


class Bad:
    def prepare(self, problem):
        return problem

    def solve(self, problem, tol, limit, start=None):
        # The harness first warms every solver up on a single contact, where all of these behave.
        return answer(problem) if problem.contacts == 1 else self.misbehave(problem)


@solver("segfault", family="bad", model="coulomb")
class Segfault(Bad):
    """Reads address zero."""

    def misbehave(self, problem):
        ctypes.string_at(0)


@solver("abort", family="bad", model="coulomb")
class Abort(Bad):
    """Calls abort."""

    def misbehave(self, problem):
        os.abort()


@solver("kills_itself", family="bad", model="coulomb")
class KillsItself(Bad):
    """Sends SIGKILL to its own process."""

    def misbehave(self, problem):
        os.kill(os.getpid(), signal.SIGKILL)


@solver("exits", family="bad", model="coulomb")
class Exits(Bad):
    """Leaves the process with a success code."""

    def misbehave(self, problem):
        os._exit(0)


@njit
def spin():
    x = 1.0
    while x > 0:
        x = x * 1.0000001 if x < 1e9 else 1.0
    return x


@solver("hangs", family="bad", model="coulomb")
class Hangs(Bad):
    """Loops for ever in native code, deaf to SIGTERM."""

    def misbehave(self, problem):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        spin()


@solver("eats_memory", family="bad", model="coulomb")
class EatsMemory(Bad):
    """Asks for memory until there is none."""

    def misbehave(self, problem):
        kept = []
        while True:
            kept.append(np.empty(2**24))


@cache
def slow_to_compile():
    statements = "\n".join(f"    x = np.sin(x) * {i} + np.cumsum(x)" for i in range(60))
    space = {"np": np}
    exec(f"def slow(x):\n{statements}\n    return x", space)
    return njit(space["slow"])


@solver("compiles", family="bad", model="coulomb")
class Compiles(Bad):
    """Compiles longer than it may run, once, and then has no answer."""

    def misbehave(self, problem):
        slow_to_compile()(np.ones(3))
        return Answer(np.zeros((problem.contacts, 2)), Status.STALLED)


@solver("lies", family="bad", model="coulomb")
class Lies(Bad):
    """Claims that zero is the answer."""

    def misbehave(self, problem):
        return answer(problem)


@solver("not_a_number", family="bad", model="coulomb")
class NotANumber(Bad):
    """Claims that NaN is the answer."""

    def misbehave(self, problem):
        return answer(problem, np.full((problem.contacts, 2), np.nan))


@solver("wrong_shape", family="bad", model="coulomb")
class WrongShape(Bad):
    """Answers for one contact too many."""

    def misbehave(self, problem):
        return answer(problem, np.zeros((problem.contacts + 1, 2)))


@solver("no_answer", family="bad", model="coulomb")
class NoAnswer(Bad):
    """Returns None."""

    def misbehave(self, problem):
        return None


@solver("changes_input", family="bad", model="coulomb")
class ChangesInput(Bad):
    """Makes the ground frictionless, to have less to do."""

    def misbehave(self, problem):
        problem.friction.setflags(write=True)
        problem.friction[:] = 0
        return answer(problem)


@solver("raises", family="bad", model="coulomb")
class Raises(Bad):
    """Raises an exception."""

    def misbehave(self, problem):
        raise RuntimeError("no idea")


@solver("talks", family="bad", model="coulomb")
class Talks(Bad):
    """Prints megabytes, from Python and through the file descriptor."""

    def misbehave(self, problem):
        for _ in range(50):
            print("x" * 100_000)
            os.write(1, b"y" * 100_000)
        return answer(problem)


@solver("gives_up", family="bad", model="coulomb")
class GivesUp(Bad):
    """Says honestly that it has no answer."""

    def misbehave(self, problem):
        return Answer(np.zeros((problem.contacts, 2)), Status.STALLED)
