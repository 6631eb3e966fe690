"""A scene in closed loop: the solver's answers move the bodies, and each answer is verified.

An answer moves the bodies even if its verdict is not `solved`; a malformed answer (of the wrong shape, or not finite) is
replaced by zero impulses. The motion ends as diverged if its energy is not finite or a million times the scene's. It also ends
if the scheme's equations have no solution. No time is reported if all calls on a problem load something or results are reused;
the verdicts on answers that are computed then count as well.
"""

import json
from collections import Counter
from time import perf_counter
from typing import Any

import numpy as np

from frictionbench.harness.cells.rows import verified
from frictionbench.harness.cells.timing import Call, Timing, check_reuse, clean_call, timed_call
from frictionbench.harness.plans.plan import SimulationCell
from frictionbench.problems import FrictionProblem
from frictionbench.problems.answer import AnswerError
from frictionbench.problems.check import Array
from frictionbench.problems.copies import duplicate, same
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES, NoSolution
from frictionbench.problems.simulate import simulate
from frictionbench.problems.verdicts import RANK, Verdict
from frictionbench.solvers import Answer, Solver, SolverInfo

DIVERGED = 1e6  # relative to the scene's energy: an inaccurate but stable motion gains far less


class _ClosedLoop:
    """The solver as a function that a scheme calls. It collects the verdicts, residuals and times of the answers."""

    def __init__(self, info: SolverInfo, solver: Solver, cell: SimulationCell) -> None:
        self._info, self._solver, self._tol = info, solver, cell.tol
        self.verdicts: Counter[Verdict] = Counter()
        self.work: Counter[str] = Counter()
        self.computed: list[Verdict] = []  # on new problems, where results are reused
        self.worst_residual = self.worst_defect = self.solver_time = self.overhead = 0.0
        self._last: tuple[FrictionProblem, Call] | None = None

    def __call__(self, problem: FrictionProblem) -> Array:
        verdict, impulse = self._verified(problem)
        self.verdicts[verdict] += 1
        return np.zeros((problem.contacts, problem.dimension)) if impulse is None else impulse

    def _verified(self, problem: FrictionProblem) -> tuple[Verdict, Array | None]:
        """Return the verdict on the solver's answer, and its impulses, or None if they are malformed."""
        handed = duplicate(problem)
        try:
            call = clean_call(lambda: self._timed(handed))
        except AnswerError as error:
            self.worst_residual = np.inf
            return malformed(error), None
        answered, self._last = perf_counter(), (handed, call)
        self.solver_time += np.nan if call.loaded else sum(call.times)
        finding = verified(problem, call.answer, self._info, self._tol)
        self.worst_residual = max(self.worst_residual, finding.residual)
        if np.isfinite(finding.residual):
            self.worst_defect = max(self.worst_defect, abs(finding.energy_defect))
        self.work.update(call.answer.work)
        verdict = finding.verdict if same(problem, handed) else Verdict.WRONG
        self.overhead += perf_counter() - answered
        return verdict, usable(problem, call.answer.impulse)

    def _timed(self, problem: FrictionProblem) -> Call:
        remote = self._info.remote and self._info.ours
        return timed_call(self._solver, problem, lambda ready: self._solver.solve(ready, self._tol, None), remote)

    def _rank(self, problem: FrictionProblem, answer: Answer) -> int:
        return RANK[verified(problem, answer, self._info, self._tol).verdict]

    def time(self) -> float | None:
        """Return the solver's time in seconds, or None if it cannot be reported. `verdict` uses what this finds computed."""
        if not np.isfinite(self.solver_time):
            return None
        timing = Timing()
        if self._last:
            problem, call = self._last
            timing.add_sample(call)
            check_reuse(timing, problem, self._timed, self._rank)
        self.computed = [verified(new, answer, self._info, self._tol).verdict for new, answer in timing.new_answers]
        return None if timing.new_answers else self.solver_time

    def verdict(self) -> tuple[Verdict, str]:
        """Return the worst verdict on any problem, and the number of problems with each verdict other than solved."""
        worst, computed = (max(known, key=RANK.__getitem__, default=Verdict.SOLVED) for known in (self.verdicts, self.computed))
        failed = [f"{count} {verdict}" for verdict, count in sorted(self.verdicts.items()) if verdict != Verdict.SOLVED]
        told = [f"of {self.verdicts.total()} problems {', '.join(failed)}"] if failed else []
        told += [f"it reuses earlier results, and what it computes is {computed}"] if RANK[computed] > RANK[worst] else []
        return max(worst, computed, key=RANK.__getitem__), "; ".join(told)


def usable(problem: FrictionProblem, impulse: Array) -> Array | None:
    """Return the impulses (nc, d) of an answer, or None if their shape is wrong or an entry is not finite."""
    fits = np.shape(impulse) == (problem.contacts, problem.dimension) and np.isfinite(impulse).all()
    return np.asarray(impulse, dtype=float) if fits else None


def malformed(error: AnswerError) -> Verdict:
    """The verdict on an answer that cannot be read."""
    return Verdict.WRONG if error.claimed else Verdict.UNSOLVED


def run_closed_loop(cell: SimulationCell, stage: Scene, info: SolverInfo, solver: Solver) -> dict[str, Any]:
    """Simulate the cell's scene, and return the columns of the row (results.schema) that follow."""
    planned = stage.steps if cell.steps is None else cell.steps
    loop = _ClosedLoop(info, solver, cell)
    times, energies, kinetic, penetrations, errors, contact_free = [], [], [], [], [], 0
    ended = ""
    try:
        for step in simulate(stage, loop, SCHEMES[cell.scheme], planned):
            start_time = perf_counter()
            times.append(step.time)
            contact_free += not len(step.contacts)
            energies.append(stage.energy(step.q, step.v))
            kinetic.append(stage.kinetic(step.q, step.v))
            if (off := stage.path_error(step.q, step.time)) is not None:
                errors.append(off)
            penetrations.append(stage.deepest_overlap(step.q))
            loop.overhead += perf_counter() - start_time
            gained = energies[-1] - energies[0]  # a difference, since the zero of the potential energy is arbitrary
            if not np.isfinite(gained) or abs(gained) > DIVERGED * energy_scale(stage, energies[:-1], kinetic[:-1]):
                ended = "the motion diverged"
                break
    except NoSolution as finding:
        ended = f"the scheme has no solution: {finding}"
    scale = energy_scale(stage, energies, kinetic)
    done = len(times) - 1
    solver_time = loop.time()
    verdict, reason = loop.verdict()
    if ended:
        verdict = Verdict.UNSOLVED if verdict == Verdict.SOLVED else verdict
        reason = f"{ended} (after {done} steps)" + (f"; {reason}" if reason else "")
    return {
        "verdict": verdict,
        "reason": reason,
        "steps": planned,
        "steps_done": done,
        "problems": loop.verdicts.total(),
        "unsolved": loop.verdicts.total() - loop.verdicts[Verdict.SOLVED],
        "worst_residual": loop.worst_residual,
        "worst_energy_defect": loop.worst_defect / scale,
        "energy_scale": scale,
        "energy_drift": (energies[-1] - energies[0]) / scale,
        "energy_rise": max(0.0, float(np.max(np.diff(energies), initial=0.0))) / scale,
        "worst_penetration": max(penetrations),
        "path_error": max(errors, default=None),
        "contact_free_steps": contact_free,
        "solver_time": solver_time,
        "overhead": loop.overhead,
        "times": times,
        "energies": energies,
        "penetrations": penetrations,
        "work": json.dumps(loop.work, sort_keys=True),
    }


def refusal(cell: SimulationCell, stage: Scene, info: SolverInfo) -> str | None:
    """Return why the solver or the scheme cannot run this simulation, or None."""
    other = None if stage.dimension in info.dimension else f"{info.name} does not take contacts of dimension {stage.dimension}"
    return info.missing or other or info.too_tight(cell.tol) or SCHEMES[cell.scheme].refuses(stage)


def energy_scale(stage: Scene, energies: list[float], kinetic: list[float]) -> float:
    """Return the largest kinetic energy plus the range of the potential, J; at least the kinetic energy of one step's fall."""
    if not energies:
        return np.inf
    potential = np.array(energies) - np.array(kinetic)
    scale = max(kinetic) + float(np.ptp(potential))
    push = stage.step * stage.force(stage.q0, stage.v0, 0.0)
    return max(scale, float(push @ stage.accelerate(stage.q0, push)) / 2)
