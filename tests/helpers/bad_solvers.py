"""Solvers that misbehave, each in its own way; each must cost its own cells alone and leave the right rows."""

import ctypes
import os
import signal
import subprocess
import sys
import threading
import time
from functools import cache

import numpy as np
from numba import njit

import frictionbench.solvers.lemke
from frictionbench.solvers import Answer, Status, solve, solver


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
    statements = "\n".join(f"    x = np.sin(x) * {i} + np.cumsum(x)" for i in range(20))
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


@solver("blocks_signals", family="bad", model="coulomb")
class BlocksSignals(Bad):
    """Blocks every signal, disarms the timers, and loops for ever in native code."""

    def misbehave(self, problem):
        signal.pthread_sigmask(signal.SIG_SETMASK, set(signal.Signals))
        for timer in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF):
            signal.setitimer(timer, 0)
        spin()


@solver("replaces_alarm", family="bad", model="coulomb")
class ReplacesAlarm(Bad):
    """Has a handler of its own for SIGALRM, and sleeps for an hour."""

    def misbehave(self, problem):
        signal.signal(signal.SIGALRM, lambda number, frame: None)
        time.sleep(3600)


@solver("hangs_at_once", family="bad", model="coulomb")
class HangsAtOnce(Bad):
    """Loops for ever from the first call, which is the harness's own to warm it up."""

    def solve(self, problem, tol, limit, start=None):
        spin()


@solver("forks", family="bad", model="coulomb")
class Forks(Bad):
    """Comes back twice: once in the process that called it, once in a child."""

    def misbehave(self, problem):
        os.fork()
        return answer(problem)


@solver("leaves_a_child", family="bad", model="coulomb")
class LeavesAChild(Bad):
    """Leaves a process behind that is nobody's child and keeps a core busy, and holds the worker's pipes open."""

    def misbehave(self, problem):
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                spin()
            os._exit(0)
        return answer(problem)


@solver("leaves_a_thread", family="bad", model="coulomb")
class LeavesAThread(Bad):
    """Leaves a thread behind that never rests."""

    def misbehave(self, problem):
        threading.Thread(target=lambda: all(iter(int, 1)), daemon=True).start()
        return answer(problem)


@solver("leaves_the_folder", family="bad", model="coulomb")
class LeavesTheFolder(Bad):
    """Goes to another folder and stays there."""

    def misbehave(self, problem):
        os.chdir("/")
        return answer(problem)


@solver("sets_clocks", family="bad", model="coulomb")
class SetsClocks(Bad):
    """Lets all clocks stand still."""

    def misbehave(self, problem):
        time.perf_counter = time.monotonic = time.time = lambda: 0.0
        return solve(problem, "lemke")


@solver("spoils_others", family="bad", model="coulomb")
class SpoilsOthers(Bad):
    """Makes lemke return nothing but zeros in this process."""

    def misbehave(self, problem):
        frictionbench.solvers.lemke.Lemke.solve = lambda self, prepared, tol, limit, start=None: None
        return answer(problem)


@solver("scales_mass", family="bad", model="coulomb")
class ScalesMass(Bad):
    """Makes all bodies light, which is not in the problem's hash, and answers that problem."""

    def misbehave(self, problem):
        problem.inverse_rows.value.setflags(write=True)
        problem.inverse_rows.value[:] *= 100
        return Answer(solve(problem.fresh(), "lemke").impulse, Status.SOLVED)


@solver("remembers", family="bad", model="coulomb")
class Remembers(Bad):
    """Thinks for long once, and then knows the answer, that there is none, by heart."""

    def misbehave(self, problem):
        if problem.contacts not in _known:
            end = time.perf_counter() + 0.02
            while time.perf_counter() < end:
                pass
            _known.add(problem.contacts)
        return Answer(np.zeros((problem.contacts, 2)), Status.STALLED)


_known: set[int] = set()


@solver("answers_once", family="bad", model="coulomb")
class AnswersOnce(Bad):
    """Solves each problem once, and is quick with zeros whenever it meets it again."""

    def misbehave(self, problem):
        if problem.hash in _seen:
            return answer(problem)
        _seen.add(problem.hash)
        return solve(problem, "lemke")


_seen: set[str] = set()


@solver("falls_silent", family="bad", model="coulomb")
class FallsSilent(Bad):
    """Solves each problem once, and returns nothing when it meets it again."""

    def misbehave(self, problem):
        if problem.hash in _told:
            return None
        _told.add(problem.hash)
        return solve(problem, "lemke")


_told: set[str] = set()


@solver("hangs_later", family="bad", model="coulomb")
class HangsLater(Bad):
    """Solves each problem once, and hangs when it meets it again."""

    def misbehave(self, problem):
        if problem.hash in _met:
            spin()
        _met.add(problem.hash)
        return solve(problem, "lemke")


_met: set[str] = set()


class Misshapen(Bad):
    """Answers right, in a form that is none."""

    def misbehave(self, problem):
        return self.misshape(solve(problem, "lemke"))


@solver("complex_impulse", family="bad", model="coulomb")
class ComplexImpulse(Misshapen):
    """Answers with complex numbers."""

    def misshape(self, answer):
        answer.impulse = answer.impulse + 0j
        return answer


@solver("text_impulse", family="bad", model="coulomb")
class TextImpulse(Misshapen):
    """Answers with text."""

    def misshape(self, answer):
        answer.impulse = answer.impulse.astype(str)
        return answer


@solver("masked_impulse", family="bad", model="coulomb")
class MaskedImpulse(Misshapen):
    """Answers with a masked array."""

    def misshape(self, answer):
        answer.impulse = np.ma.masked_greater(answer.impulse, 0)
        return answer


@solver("slow_impulse", family="bad", model="coulomb")
class SlowImpulse(Misshapen):
    """Answers with what takes for ever to become an array."""

    def misshape(self, answer):
        answer.impulse = type("Slow", (), {"__array__": lambda self, *_, **__: spin()})()
        return answer


@solver("text_status", family="bad", model="coulomb")
class TextStatus(Misshapen):
    """Says "solved" where a Status is wanted."""

    def misshape(self, answer):
        answer.status = "solved"
        return answer


@solver("half_a_pivot", family="bad", model="coulomb")
class HalfAPivot(Misshapen):
    """Counts in halves."""

    def misshape(self, answer):
        answer.work = {"pivots": 0.5}
        return answer


@solver("counts_in_numpy", family="good", model="coulomb")
class CountsInNumpy(Misshapen):
    """Counts in numpy's integers, which are whole numbers like others."""

    def misshape(self, answer):
        answer.work = {"pivots": np.int64(7)}
        return answer


@solver("talks_rubbish", family="good", model="coulomb")
class TalksRubbish(Misshapen):
    """Answers right, with ten megabytes of unprintable remarks."""

    def misshape(self, answer):
        answer.detail = "\ud800\0" * 5_000_000
        return answer


@solver("leaves_politely", family="bad", model="coulomb")
class LeavesPolitely(Bad):
    """Calls sys.exit."""

    def misbehave(self, problem):
        sys.exit(3)


@solver("shouts", family="bad", model="coulomb")
class Shouts(Bad):
    """Writes rubbish to everything that is open."""

    def misbehave(self, problem):
        for number in map(int, os.listdir("/proc/self/fd")):
            try:
                os.set_blocking(number, False)
                os.write(number, b"\0\1\2 rubbish \n" * 1000)
            except OSError:
                continue
        return answer(problem)


@solver("starts_programs", family="bad", model="coulomb")
class StartsPrograms(Bad):
    """Starts programs that outlive their cell, in a session of their own."""

    def misbehave(self, problem):
        for _ in range(3):
            subprocess.Popen([sys.executable, "-c", "import time; time.sleep(3600)"], start_new_session=True)
        return answer(problem)
