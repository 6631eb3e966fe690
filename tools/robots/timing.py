"""The section of docs/performance.md on steps of robots: hybrid compared with MuJoCo's constraint stage on the same steps.

OPENBLAS_NUM_THREADS=1 python -m tools.robots.timing [MODEL ...]

Models and behaviours are those of tools.robots.models, in closed loop by frictionbench.mujoco.step. Before each step both get
the same input: MuJoCo's mj_fwdConstraint its data after mj_forward, with the acceleration of the previous step as a warm start;
hybrid the assembled problem, cold or with the impulses of the previous step. Needs MuJoCo and the packages of the models.
Pinocchio's solver is timed if it is installed. BLAS must have one thread, since several would wait for each other on a busy
machine.
"""

import sys
from collections.abc import Callable, Iterator
from functools import partial
from time import perf_counter_ns
from typing import Any, NamedTuple

import mujoco as mj
import numpy as np
from scipy.stats import binom

import frictionbench as fb
from frictionbench.problems import FrictionProblem, InputError
from tools.robots.models import MODELS, Model, begin

WAYS = tuple((tol, warm) for tol in (1e-6, 1e-8) for warm in (False, True))
OTHER = "pinocchio[method=admm,settings=tuned]"
STEPS, APART, ROUNDS, LEAD = 30, 5, 5, 20  # timed steps of a motion; distance between them; repeats; steps before the first
HEAD = f"""## Steps of robots

This table is made by `python -m tools.robots.timing`. *MuJoCo* is `mj_fwdConstraint`, with MuJoCo's soft and convex law. The
next columns are calls of `fb.solve(problem, "hybrid")` from Python on the exact problems of the same steps, with form, setup
and residual: the median time over the steps in µs, and the median ratio to MuJoCo. Cold starts are from zero impulses, warm
ones from those of the step before, as in MuJoCo. Each time is the median of {ROUNDS} calls after {ROUNDS} uncounted ones.
*first* is the first of these, cold at 1e-06, as in a simulation, which solves each problem once. *worst* is the 99th
percentile of the cold call at 1e-08 over its median. *problem* is the time to make the FrictionProblem from dense arrays.
*pinocchio* is `{OTHER}`, with Coulomb's law, cold at 1e-06, over the steps that it
solves, and their number unless it is all. A dash means that it takes none, because it has no form for dry friction of joints.
"""


class Timed(NamedTuple):
    """One step. Times are in µs. calls: the first and the median of each of WAYS; solved: whether all are within tolerance."""

    contacts: int
    joints: int
    soft: float
    made: float
    calls: tuple[tuple[float, float], ...]
    solved: bool
    other: float  # NaN without an answer within the tolerance


def section(names: tuple[str, ...] = ()) -> str:
    """Return the section in Markdown."""
    titles = [f"{'warm' if warm else 'cold'} {tol:g}" for tol, warm in WAYS]
    before = ("model", "velocities", "contacts", "joints", "steps", "MuJoCo", "first")
    columns = (*before, *titles, "worst", "problem", "pinocchio", "unsolved")
    lines = [HEAD, f"| {' | '.join(columns)} |", "|---|" + "--:|" * (len(columns) - 1)]
    ratios, worst = [], []
    for model in MODELS:
        if not names or model.name in names:
            found = [step for behaviour in (model.behaviours[0], model.behaviours[-1]) for step in _timed(model, behaviour)]
            if found:
                calls, soft = np.array([step.calls for step in found]), np.array([step.soft for step in found])
                ratios.append(np.median(calls[..., 1] / soft[:, None], axis=0))
                worst.append(float(np.percentile(calls[:, -2, 1], 99) / np.median(calls[:, -2, 1])))
                lines.append(_line(model, found, calls, ratios[-1], worst[-1]))
                print(lines[-1], file=sys.stderr, flush=True)
    told = ", ".join(f"{title} {_middle(ratio)}" for title, ratio in zip(titles, np.transpose(ratios), strict=True))
    summary = f"""The median over {len(ratios)} models of the ratio, with its 95 % interval between two of its values: {told};
of *worst* {_middle(worst)}. The models are a choice, not a sample of those in use."""
    return "\n".join([*lines, "", summary, ""])


def _middle(values: Any) -> str:
    low, high = np.sort(values)[[k := int(binom.ppf(0.025, len(values), 0.5)) - 1, -1 - k]]
    return f"{np.median(values):.1f} ({low:.1f} to {high:.1f})"


def _line(model: Model, found: list[Timed], calls: Any, ratio: Any, worst: float) -> str:
    middle, soft = np.median(calls, axis=0), float(np.median([step.soft for step in found]))
    cells = [f"{time:.0f} ({times:.1f})" for time, times in zip(middle[:, 1], ratio, strict=True)]
    contacts, joints = (int(np.median([getattr(step, name) for step in found])) for name in ("contacts", "joints"))
    made, unsolved = np.median([step.made for step in found]), sum(not step.solved for step in found)
    sizes, ends = [model.load().nv, contacts, joints, len(found)], [f"{worst:.1f}", f"{made:.0f}", _told(found)]
    known = [model.name, *sizes, f"{soft:.1f}", f"{middle[0, 0]:.0f}", *cells, *ends]
    return f"| {' | '.join(map(str, known))} | {unsolved or ''} |"


def _told(found: list[Timed]) -> str:
    """Return the median time of OTHER on the steps that it solves, the ratio to MuJoCo's, and their number unless it is all."""
    answered = [(step.other, step.other / step.soft) for step in found if step.other > 0]
    if not answered:
        return "–"
    time, over = np.median(answered, axis=0)
    return f"{time:.0f} ({over:.0f})" + f", {len(answered)} solved" * (len(answered) < len(found))


def _timed(model: Model, behaviour: str) -> Iterator[Timed]:
    """Time the steps with contacts, limits or dry friction of one motion."""
    compiled = model.load()
    data, drive = begin(compiled, behaviour, seed=1)
    engine, before = mj.MjData(compiled), None
    for k in range(LEAD + STEPS * APART):
        drive(data, k)
        if k >= LEAD and k % APART == 0:
            problem = fb.mujoco.problem(compiled, data)
            if problem.contacts:
                start = np.zeros((problem.contacts, 3)) if before is None else fb.mujoco.start(compiled, data, before)
                mj.mj_copyData(engine, compiled, data)
                yield _step(compiled, engine, problem, start)
        before = fb.mujoco.step(compiled, data, tol=1e-10, before=before)


def _step(model: Any, engine: Any, problem: FrictionProblem, start: Any) -> Timed:
    mj.mj_forward(model, engine)
    warm = engine.qacc_warmstart.copy()

    def soft(_: Any) -> None:
        engine.qacc_warmstart[:] = warm
        mj.mj_fwdConstraint(model, engine)

    def made(_: Any) -> FrictionProblem:
        return FrictionProblem(**fields, dimension=3)

    calls, solved = [], True
    for tol, is_warm in WAYS:
        call = partial(fb.solve, solver="hybrid", tol=tol, start=start if is_warm else None)
        calls.append(_times(call, problem.fresh))
        solved = solved and fb.residual(problem, call(problem).impulse) <= tol
    fields = {name: getattr(problem, name) for name in ("free_velocity", "bias", "friction", "friction_bias", "joint_bias")}
    fields |= {name: getattr(problem, name).toarray() for name in ("mass", "normal", "tangent", "joints")}
    sizes, (_, softly), (_, making) = (problem.contacts, len(problem.joint_bias)), _times(soft), _times(made)
    return Timed(*sizes, softly, making, tuple(calls), solved, _other(problem))


def _other(problem: FrictionProblem) -> float:
    """Return the time of OTHER in µs; NaN if it is not installed, refuses the problem or has no answer within 1e-6."""
    call = partial(fb.solve, solver=OTHER, tol=1e-6, time_limit=1.0)
    try:
        solved = fb.residual(problem, call(problem.fresh()).impulse) <= 1e-6
    except InputError:
        return np.nan
    return _times(call, problem.fresh)[1] if solved else np.nan


def _times(call: Callable[[Any], Any], given: Callable[[], Any] = lambda: None) -> tuple[float, float]:
    """Return the time of the first call and the median of the last ROUNDS of 2 ROUNDS calls, µs, each on a new input."""
    times = []
    for _ in range(2 * ROUNDS):
        one = given()
        begun = perf_counter_ns()
        call(one)
        times.append((perf_counter_ns() - begun) / 1e3)
    return times[0], float(np.median(times[ROUNDS:]))


if __name__ == "__main__":
    sys.stdout.write(section(tuple(sys.argv[1:])))
