"""A scene in closed loop: the solver's own answers move the bodies, and each answer is verified as it comes.

An answer that is no answer (wrong shape, not finite) moves nothing: the contacts are then left without impulses. A motion
whose energy is no longer finite, or a million times the scene's, is broken off as diverged.
"""

import time
from typing import Any

import numpy as np

from harness.plan import DriveCell
from problems import FrictionProblem, scene
from problems.check import Array
from problems.residual import residual
from problems.scene import Scene
from problems.schemes import SCHEMES
from problems.simulate import ledger_defect, penetration, simulate
from results.schema import SOLVED, UNSOLVED
from solvers import Solver

DIVERGED = 1e6


class _Driver:
    """The solver as a scheme calls it; keeps what was found on the way."""

    def __init__(self, solver: Solver, tol: float) -> None:
        self._solver, self._tol = solver, tol
        self.problems = self.unsolved = self.most_contacts = 0
        self.worst_residual = self.worst_defect = self.solver_time = 0.0

    def __call__(self, problem: FrictionProblem) -> Array:
        start = time.perf_counter()
        answer = self._solver.solve(self._solver.prepare(problem.fresh()), self._tol, None)
        self.solver_time += time.perf_counter() - start
        impulse = np.asarray(answer.impulse, dtype=float)
        if impulse.shape != (problem.contacts, problem.dimension) or not np.isfinite(impulse).all():
            found, impulse = np.inf, np.zeros((problem.contacts, problem.dimension))
        else:
            found = residual(problem, impulse)
        self.problems += 1
        self.unsolved += found > self._tol
        self.most_contacts = max(self.most_contacts, problem.contacts)
        self.worst_residual = max(self.worst_residual, found)
        self.worst_defect = max(self.worst_defect, abs(ledger_defect(problem, impulse)))
        return impulse


def drive(cell: DriveCell, solver: Solver) -> dict[str, Any]:
    """The drive's part of a row of results.schema.DRIVES."""
    stage = scene(cell.scene, **cell.parameters)
    planned = stage.steps if cell.steps is None else cell.steps
    driver = _Driver(solver, cell.tol)
    times, energies, kinetic, penetrations = [], [], [], []
    for step in simulate(stage, driver, SCHEMES[cell.scheme], planned):
        times.append(step.time)
        energies.append(stage.energy(step.q, step.v))
        kinetic.append(float(step.v @ (stage.mass @ step.v)) / 2)
        penetrations.append(penetration(stage, step.q))
        if not np.isfinite(energies[-1]) or abs(energies[-1]) > DIVERGED * _scale(stage, energies[:-1], kinetic[:-1]):
            break
    scale = _scale(stage, energies, kinetic)
    done = len(times) - 1
    diverged = done < planned
    return {
        "verdict": UNSOLVED if diverged or driver.unsolved else SOLVED,
        "reason": "diverged" if diverged else f"{driver.unsolved} problems missed the tolerance" if driver.unsolved else "",
        "step_size": stage.step,
        "steps": planned,
        "steps_done": done,
        "problems": driver.problems,
        "unsolved": driver.unsolved,
        "most_contacts": driver.most_contacts,
        "worst_residual": driver.worst_residual,
        "worst_energy_defect": driver.worst_defect / scale,
        "energy_scale": scale,
        "energy_drift": (energies[-1] - energies[0]) / scale,
        "energy_rise": max(0.0, float(np.max(np.diff(energies), initial=0.0))) / scale,
        "worst_penetration": max(penetrations),
        "solver_time": driver.solver_time,
        "times": times,
        "energies": energies,
        "penetrations": penetrations,
    }


def _scale(stage: Scene, energies: list[float], kinetic: list[float]) -> float:
    """The largest kinetic energy plus the range of the potential, J; where nothing moves, what one step of fall gives."""
    if not energies:
        return np.inf
    potential = np.array(energies) - np.array(kinetic)
    scale = max(kinetic) + float(np.ptp(potential))
    push = stage.step * stage.force(stage.q0, stage.v0, 0.0)
    return max(scale, float(push @ (push / stage.weights)) / 2)
