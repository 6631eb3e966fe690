"""Solvers in closed loop, compared with MuJoCo's own step on the same models.

    python -m tools.robots.loop [SECONDS [MODEL ...]] > loop.tsv

Each solver moves each model by `frictionbench.mujoco.step`, warm, for SECONDS of the model's time or LIMIT of the processor's,
from the same start and with the same controls. A line each: steps, how many within 1e-8 by the verifier's residual, the median
time of the solver's call in ms; the time of the whole step, from collisions to the new positions, in ms (median, 99th
percentile, longest) and its share within 1 ms; the largest energy defect over the largest kinetic energy; the deepest
penetration that a step begins with, in mm or mrad; the largest error of an equality at the end. Of MuJoCo the whole step is
mj_step. In place of the count are medians over every tenth step, as `judge` measures it (problems.measures), so that overlaps
which are left do not count: the residual, and the largest defect of friction in the same unit.
"""

import sys
from collections.abc import Sequence
from time import thread_time
from typing import Any

import mujoco as mj
import numpy as np

import frictionbench as fb
from frictionbench.problems import judged, violations
from tools.robots.models import MODELS, begin

TOL, LIMIT, WARMED = 1e-8, 8.0, 20  # residual; processor time, s; steps before measurements, in which kernels are compiled
NAMES = ("humanoid", "quadruped", "dog", "fruit_fly", "stacker", "hand_block", "adroit_relocate", "fetch_pick")
SOLVERS = ("hybrid", "interior_point", "nsgs", "proximal_newton", "mujoco")


class Tally:
    """Measurements along a motion."""

    def __init__(self) -> None:
        self.residual: list[float] = []
        self.friction: list[float] = []  # of MuJoCo's steps: the largest defect of friction, over the contact's unit
        self.seconds: list[float] = []  # whole steps
        self.solving: list[float] = []
        self.defect = self.kinetic = self.depth = self.drift = 0.0

    def meet(self, model: Any, data: Any, seconds: float) -> None:
        """Add the measurements after a step."""
        active = data.efc_type >= int(mj.mjtConstraint.mjCNSTR_LIMIT_JOINT)
        self.depth = max(self.depth, float(-data.efc_pos[active].min(initial=0.0)))
        error = data.efc_pos[data.efc_type == mj.mjtConstraint.mjCNSTR_EQUALITY]
        self.drift = float(np.abs(error).max(initial=0.0))
        self.seconds.append(seconds)
        mj.mj_energyVel(model, data)
        self.kinetic = max(self.kinetic, float(data.energy[1]))

    def line(self) -> list[str]:
        """Return the columns from `steps` on."""
        ms = 1e3 * np.array(self.seconds)
        solved = f"{sum(size <= TOL for size in self.residual)} of {len(self.residual)}"
        if self.friction:  # MuJoCo's law is soft, so that no step can be within the tolerance
            solved = f"{np.median(self.residual):.1g}, friction {np.median(self.friction):.1g}, of {len(self.residual)}"
        times = [f"{1e3 * np.median(self.solving):.3g}" if self.solving else ""]
        times += [f"{value:.3g}" for value in (*np.percentile(ms, [50, 99]), ms.max())]
        sizes = self.defect / max(self.kinetic, 1e-300), 1e3 * self.depth, 1e3 * self.drift
        return [str(len(ms)), solved, *times, f"{np.mean(ms <= 1):.3f}", *(f"{value:.2g}" for value in sizes)]


def run(name: str, solver: str, seconds: float | None) -> Tally:
    """Simulate one model with one solver, for WARMED steps if no seconds are given."""
    model = next(one for one in MODELS if one.name == name).load()
    data, drive = begin(model, "smooth", 0)
    tally, before, begun = Tally(), None, thread_time()
    for k in range(WARMED if seconds is None else round(seconds / model.opt.timestep)):
        drive(data, k)
        if solver == "mujoco" and k % 10 == 0:
            _judge(model, data, tally)
        start = thread_time()
        if solver == "mujoco":
            mj.mj_step(model, data)
        else:
            before = fb.mujoco.step(model, data, solver, TOL, before)
        tally.meet(model, data, thread_time() - start)
        if before is not None:
            tally.solving.append(before.seconds)
            tally.residual.append(before.residual)
            tally.defect = max(tally.defect, abs(before.energy["defect"]))
        if thread_time() - begun > LIMIT:
            break
    return tally


def _judge(model: Any, data: Any, tally: Tally) -> None:
    step = fb.capture.mujoco(model, data)
    if step.problem.contacts:
        problem = judged(step)
        tally.residual.append(fb.residual(problem, step.impulse))
        tally.friction.append(float((np.max(violations(problem, step.impulse)[1:], axis=0) / problem.units).max()))


def main(seconds: float, names: Sequence[str]) -> None:
    print("model\tsolver\tsteps\tsolved\tsolving\tstep\tp99\tlongest\twithin 1 ms\tenergy defect\tdeepest\tdrift")
    for name in names:
        for solver in SOLVERS:
            run(name, solver, None)
            print(name, solver, *run(name, solver, seconds).line(), sep="\t", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 1.0, sys.argv[2:] or NAMES)
