"""How many steps of other people's models `hybrid` solves, for all MuJoCo models below a folder.

    python -m tools.robots.others FOLDER [TEXT ...]     # of the files whose paths hold one of the texts, all by default

A robot that is the only body in its world gets a floor and a free joint; scenes are not changed. For each of five behaviours
(tools.robots.models), 20 steps are simulated in closed loop with exact solutions, and every tenth of 100 steps by MuJoCo is
solved. A motion ends if a velocity exceeds FAST. A line per model has the number of velocities, of steps with contacts, limits
or dry friction, of those not verified to TOL, and the largest number of rows. Files that MuJoCo does not compile by themselves,
such as parts that others include, are listed with its reason.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco as mj
import numpy as np

import frictionbench as fb
from tools.robots.models import ALL, begin, compiled

TOL, FAST = 1e-8, 1e3  # residual; m/s and rad/s: controls without a force limit accelerate some models beyond


def load(path: Path) -> Any:
    """Return the model of a file. Errors: ValueError from MuJoCo."""
    spec = mj.MjSpec.from_file(str(path))
    return compiled(spec, bare=len(spec.worldbody.bodies) == 1)


def steps(model: Any, behaviour: str, seed: int) -> Iterator[tuple[int, float]]:
    """Yield the number of rows and the residual of each step that is solved."""
    data, drive = begin(model, behaviour, seed)
    for k in range(100):
        drive(data, k)
        if k % 10 == 9 and (problem := fb.mujoco.problem(model, data)).contacts:
            yield problem.contacts, _residual(problem)
        mj.mj_step(model, data)
        if not np.abs(data.qvel).max() < FAST:
            break
    (data, drive), before = begin(model, behaviour, seed + len(ALL)), None
    for k in range(20):
        drive(data, k)
        before = fb.mujoco.step(model, data, "hybrid", TOL, before)
        if len(before.impulse):
            yield len(before.impulse), before.residual if before.status is fb.Status.SOLVED else np.inf
        if not np.abs(data.qvel).max() < FAST:
            break


def _residual(problem: fb.FrictionProblem) -> float:
    answer = fb.solve(problem, "hybrid", tol=TOL)
    return fb.residual(problem, answer.impulse) if answer.status is fb.Status.SOLVED else np.inf


def main(folder: Path, texts: list[str]) -> None:
    total = lost = 0
    for path in sorted(folder.rglob("*.xml")):
        if texts and not any(text in str(path) for text in texts):
            continue
        try:
            model = load(path)
        except ValueError as error:
            print(path.stem, "is left out:", " ".join(str(error).split())[:90], flush=True)
            continue
        found = [step for seed, name in enumerate(ALL) for step in steps(model, name, seed)] if model.nv else []
        bad = sum(not residual <= TOL for _, residual in found)
        total, lost = total + len(found), lost + bad
        print(path.parent.name, path.stem, model.nv, len(found), bad, max((rows for rows, _ in found), default=0), flush=True)
    print(total, "steps,", lost, "of them not solved")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
