"""Solvers that attack the process they run in, and all of the harness that they find there."""

import contextlib
import gc
import json
import os
import sys
import time

import numpy as np

from frictionbench.solvers import Answer, Status, solver


class Bad:
    def solve(self, problem, tol, limit, start=None):
        zeros = Answer(np.zeros((problem.contacts, problem.dimension)), Status.SOLVED)
        return zeros if problem.contacts == 1 else self.misbehave(problem) or zeros


@solver("patches_verifier", family="bad", model="coulomb")
class PatchesVerifier(Bad):
    """Makes everything that judges its answer in this process say that it is right, and returns zeros."""

    def misbehave(self, problem):
        for module in list(sys.modules.values()):
            for name in ("residual", "residual_floor"):
                if callable(getattr(module, name, None)):
                    setattr(module, name, lambda *_, **__: 0.0)
        np.isfinite = lambda x: np.ones(np.shape(x), bool)


@solver("finds_reference", family="bad", model="coulomb")
class FindsReference(Bad):
    """Looks for the harness's own copies of the problem, by the garbage collector and the frames above, and changes them."""

    def misbehave(self, problem):
        kind, frame = type(problem), sys._getframe()
        found = [one for one in gc.get_objects() if type(one) is kind]
        while frame is not None:
            found += [one for one in frame.f_locals.values() if type(one) is kind]
            frame = frame.f_back
        for one in found:
            one.friction.setflags(write=True)
            one.friction[:] = 0.0


@solver("forges_reply", family="bad", model="coulomb")
class ForgesReply(Bad):
    """Writes a well-formed reply to every pipe: the row of another solver's cell, solved."""

    def misbehave(self, problem):
        row = {"key": "solve-0", "solver": "lemke", "variant": "lemke", "verdict": "solved", "residual": 0.0, "tol": 1.0}
        for number in map(int, os.listdir("/proc/self/fd")):
            with contextlib.suppress(OSError):
                os.set_blocking(number, False)
                os.write(number, json.dumps({"value": row, "helpers": [os.getppid()]}).encode() + b"\n")
        os._exit(0)


@solver("answer_of_a_subclass", family="bad", model="coulomb")
class AnswerOfASubclass(Bad):
    """Returns a subclass of Answer whose impulse is another each time, in a subclass of ndarray that is equal to everything."""

    def misbehave(self, problem):
        class Equal(np.ndarray):
            __eq__ = __le__ = __lt__ = lambda self, other: np.ones(self.shape, bool)
            __array_function__ = __array_ufunc__ = lambda self, *_, **__: np.zeros(1)

        class Changing(Answer):
            impulse = property(lambda self: np.full((problem.contacts, 2), time.perf_counter()).view(Equal), lambda *_: None)

        return Changing(None, Status.SOLVED)
