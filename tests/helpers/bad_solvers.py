"""Solvers that misbehave in different ways. A run must give their cells the right verdict and leave all others unaffected."""

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
        # The harness first warms every solver up on a single contact, for which most of these answer correctly.
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


@solver("sends_sigkill", family="bad", model="coulomb")
class SendsSigkill(Bad):
    """Sends SIGKILL to its own process."""

    def misbehave(self, problem):
        os.kill(os.getpid(), signal.SIGKILL)


@solver("calls_os_exit", family="bad", model="coulomb")
class CallsOsExit(Bad):
    """Ends the process with exit code 0."""

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
    """Loops for ever in native code and ignores SIGTERM."""

    def misbehave(self, problem):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        spin()


@solver("exhausts_memory", family="bad", model="coulomb")
class ExhaustsMemory(Bad):
    """Allocates memory until the limit is reached."""

    def misbehave(self, problem):
        arrays = []
        while True:
            arrays.append(np.empty(2**24))


@cache
def slow_to_compile():
    statements = "\n".join(f"    x = np.sin(x) * {i} + np.cumsum(x)" for i in range(20))
    space = {"np": np}
    exec(f"def slow(x):\n{statements}\n    return x", space)
    return njit(space["slow"])


@solver("compiles_slowly", family="bad", model="coulomb")
class CompilesSlowly(Bad):
    """Compiles a kernel of its own for longer than the time limit, in a cell and not when it is warmed up."""

    def misbehave(self, problem):
        slow_to_compile()(np.ones(3))
        return Answer(np.zeros((problem.contacts, 2)), Status.STALLED)


@solver("wrong_zero", family="bad", model="coulomb")
class WrongZero(Bad):
    """Returns zero impulses with status SOLVED."""

    def misbehave(self, problem):
        return answer(problem)


@solver("nan_impulse", family="bad", model="coulomb")
class NanImpulse(Bad):
    """Returns NaN impulses with status SOLVED."""

    def misbehave(self, problem):
        return answer(problem, np.full((problem.contacts, 2), np.nan))


@solver("wrong_shape", family="bad", model="coulomb")
class WrongShape(Bad):
    """Returns impulses for one contact too many."""

    def misbehave(self, problem):
        return answer(problem, np.zeros((problem.contacts + 1, 2)))


@solver("returns_none", family="bad", model="coulomb")
class ReturnsNone(Bad):
    """Returns None."""

    def misbehave(self, problem):
        return None


@solver("modifies_friction", family="bad", model="coulomb")
class ModifiesFriction(Bad):
    """Sets the friction coefficients of its input to zero."""

    def misbehave(self, problem):
        problem.friction.setflags(write=True)
        problem.friction[:] = 0
        return answer(problem)


@solver("raises", family="bad", model="coulomb")
class Raises(Bad):
    """Raises an exception."""

    def misbehave(self, problem):
        raise RuntimeError("no idea")


@solver("prints", family="bad", model="coulomb")
class Prints(Bad):
    """Prints megabytes to standard output, from Python and through the file descriptor."""

    def misbehave(self, problem):
        for _ in range(50):
            print("x" * 100_000)
            os.write(1, b"y" * 100_000)
        return answer(problem)


@solver("reports_stalled", family="bad", model="coulomb")
class ReportsStalled(Bad):
    """Reports STALLED."""

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
    """Replaces the handler of SIGALRM and sleeps for an hour."""

    def misbehave(self, problem):
        signal.signal(signal.SIGALRM, lambda number, frame: None)
        time.sleep(3600)


@solver("hangs_in_warm_up", family="bad", model="coulomb")
class HangsInWarmUp(Bad):
    """Loops for ever in every call, from the warm-up on."""

    def solve(self, problem, tol, limit, start=None):
        spin()


@solver("forks", family="bad", model="coulomb")
class Forks(Bad):
    """Forks and returns in both the parent and the child process."""

    def misbehave(self, problem):
        os.fork()
        return answer(problem)


@solver("daemonises_child", family="bad", model="coulomb")
class DaemonisesChild(Bad):
    """Leaves an orphaned process in a session of its own, which loops for ever and holds the worker's pipes open."""

    def misbehave(self, problem):
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                spin()
            os._exit(0)
        return answer(problem)


@solver("leaves_thread", family="bad", model="coulomb")
class LeavesThread(Bad):
    """Leaves a thread running that loops for ever."""

    def misbehave(self, problem):
        threading.Thread(target=lambda: all(iter(int, 1)), daemon=True).start()
        return answer(problem)


@solver("changes_directory", family="bad", model="coulomb")
class ChangesDirectory(Bad):
    """Changes the working directory."""

    def misbehave(self, problem):
        os.chdir("/")
        return answer(problem)


@solver("freezes_clocks", family="bad", model="coulomb")
class FreezesClocks(Bad):
    """Replaces the clocks of Python's time module by constants."""

    def misbehave(self, problem):
        time.perf_counter = time.monotonic = time.time = lambda: 0.0
        return solve(problem, "lemke")


@solver("patches_lemke", family="bad", model="coulomb")
class PatchesLemke(Bad):
    """Replaces the solve method of lemke in this process by one that returns None."""

    def misbehave(self, problem):
        frictionbench.solvers.lemke.Lemke.solve = lambda self, prepared, tol, limit, start=None: None
        return answer(problem)


@solver("modifies_mass", family="bad", model="coulomb")
class ModifiesMass(Bad):
    """Multiplies the inverse mass matrix by 100, which does not enter the problem's hash, and solves the changed problem."""

    def misbehave(self, problem):
        problem.inverse_rows.value[:] *= 100
        return Answer(solve(problem.fresh(), "lemke").impulse, Status.SOLVED)


@solver("caches_result", family="bad", model="coulomb")
class CachesResult(Bad):
    """Takes 20 ms for the first problem of each size and returns at once afterwards, always STALLED."""

    def misbehave(self, problem):
        if problem.contacts not in _sizes_seen:
            end = time.perf_counter() + 0.02
            while time.perf_counter() < end:
                pass
            _sizes_seen.add(problem.contacts)
        return Answer(np.zeros((problem.contacts, 2)), Status.STALLED)


_sizes_seen: set[int] = set()


@solver("zero_on_repeat", family="bad", model="coulomb")
class ZeroOnRepeat(Bad):
    """Solves each problem once, and returns zeros at once for repeats."""

    def misbehave(self, problem):
        if problem.hash in _zero_repeats:
            return answer(problem)
        _zero_repeats.add(problem.hash)
        return solve(problem, "lemke")


_zero_repeats: set[str] = set()


@solver("none_on_repeat", family="bad", model="coulomb")
class NoneOnRepeat(Bad):
    """Solves each problem once, and returns None for repeats."""

    def misbehave(self, problem):
        if problem.hash in _answered:
            return None
        _answered.add(problem.hash)
        return solve(problem, "lemke")


_answered: set[str] = set()


@solver("hangs_on_repeat", family="bad", model="coulomb")
class HangsOnRepeat(Bad):
    """Solves each problem once, and hangs on repeats."""

    def misbehave(self, problem):
        if problem.hash in _hang_repeats:
            spin()
        _hang_repeats.add(problem.hash)
        return solve(problem, "lemke")


_hang_repeats: set[str] = set()


class ChangedAnswer(Bad):
    """Base class: solves the problem and then changes the type of a field of the answer."""

    def misbehave(self, problem):
        return self.change(solve(problem, "lemke"))


@solver("complex_impulse", family="bad", model="coulomb")
class ComplexImpulse(ChangedAnswer):
    """Returns complex impulses."""

    def change(self, answer):
        answer.impulse = answer.impulse + 0j
        return answer


@solver("text_impulse", family="bad", model="coulomb")
class TextImpulse(ChangedAnswer):
    """Returns impulses as strings."""

    def change(self, answer):
        answer.impulse = answer.impulse.astype(str)
        return answer


@solver("masked_impulse", family="bad", model="coulomb")
class MaskedImpulse(ChangedAnswer):
    """Returns impulses as a masked array."""

    def change(self, answer):
        answer.impulse = np.ma.masked_greater(answer.impulse, 0)
        return answer


@solver("slow_impulse", family="bad", model="coulomb")
class SlowImpulse(ChangedAnswer):
    """Returns an object whose conversion to an array never ends."""

    def change(self, answer):
        answer.impulse = type("Slow", (), {"__array__": lambda self, *_, **__: spin()})()
        return answer


@solver("text_status", family="bad", model="coulomb")
class TextStatus(ChangedAnswer):
    """Returns the string "solved" instead of a Status."""

    def change(self, answer):
        answer.status = "solved"
        return answer


@solver("fractional_work", family="bad", model="coulomb")
class FractionalWork(ChangedAnswer):
    """Returns a work counter that is no integer."""

    def change(self, answer):
        answer.work = {"pivots": 0.5}
        return answer


@solver("numpy_integer_work", family="good", model="coulomb")
class NumpyIntegerWork(ChangedAnswer):
    """Returns a work counter as a numpy integer, which is accepted."""

    def change(self, answer):
        answer.work = {"pivots": np.int64(7)}
        return answer


@solver("long_detail", family="good", model="coulomb")
class LongDetail(ChangedAnswer):
    """Solves the problem and returns ten megabytes of unprintable characters as detail."""

    def change(self, answer):
        answer.detail = "\ud800\0" * 5_000_000
        return answer


@solver("calls_sys_exit", family="bad", model="coulomb")
class CallsSysExit(Bad):
    """Calls sys.exit."""

    def misbehave(self, problem):
        sys.exit(3)


@solver("writes_to_fds", family="bad", model="coulomb")
class WritesToFds(Bad):
    """Writes random bytes to all open file descriptors."""

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
    """Starts programs in sessions of their own that run longer than the cell."""

    def misbehave(self, problem):
        for _ in range(3):
            subprocess.Popen([sys.executable, "-c", "import time; time.sleep(3600)"], start_new_session=True)
        return answer(problem)
