"""Problems for the cells: recorded while the reference solver drives a scene, labelled and stored by their hash."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from harness.plan import Source
from problems import FrictionProblem, scene
from problems.check import Array
from problems.labels import labels
from problems.random_problem import random_problem
from problems.residual import residual
from problems.simulate import simulate
from problems.storage import load, save
from solvers import solve

REFERENCE = "lemke"
Entry = dict[str, Any]


def collect(folder: Path, source: Source) -> list[Entry]:
    """The source's problems, stored under folder/problems, as plain rows of facts; stored once, then read."""
    store = folder / "problems"
    listed = store / f"{source.key}.json"
    if listed.exists():
        return json.loads(listed.read_text(encoding="utf-8"))
    store.mkdir(parents=True, exist_ok=True)
    entries: dict[str, Entry] = {}
    for step, phase, problem in _problems(source):
        if problem.hash not in entries:
            save(problem, store / f"{problem.hash}.npz")
            entries[problem.hash] = facts(source, step, phase, problem)
    partial = listed.with_suffix(".partial")
    partial.write_text(json.dumps(list(entries.values())), encoding="utf-8")
    partial.replace(listed)
    return list(entries.values())


def stored(folder: Path, problem: str) -> FrictionProblem:
    """A stored problem by its hash. Errors: InputError where the file is missing or damaged."""
    return load(folder / "problems" / f"{problem}.npz")


def _problems(source: Source) -> list[tuple[int, str, FrictionProblem]]:
    if source.scene == "random":
        return [(0, "step", random_problem(**source.parameters))]
    stage = scene(source.scene, **source.parameters)
    if source.pick == 0:
        return [(0, "step", stage.problem())]

    def reference(problem: FrictionProblem) -> Array:
        return solve(problem, REFERENCE, tol=1e-10).impulse

    met = [
        (index, solved.phase, solved.problem)
        for index, step in enumerate(simulate(stage, reference, steps=source.steps))
        for solved in step.solved
        if _worth_solving(solved.problem)
    ]
    chosen = np.unique(np.linspace(0, len(met) - 1, min(source.pick, len(met))).astype(int))
    return [met[i] for i in chosen]


def _worth_solving(problem: FrictionProblem) -> bool:
    return residual(problem, np.zeros((problem.contacts, problem.dimension))) > 0


def facts(source: Source, step: int, phase: str, problem: FrictionProblem) -> Entry:
    """What a row says of a problem: harness.rows.PROBLEM_FACTS."""
    found = labels(problem)
    return {
        "problem": problem.hash,
        "scene": source.scene,
        "parameters": json.dumps(source.parameters, sort_keys=True),
        "step": step,
        "phase": phase,
        "contacts": problem.contacts,
        "dimension": problem.dimension,
        "velocities": len(problem.free_velocity),
        "size": found.size,
        "rank": found.rank,
        "condition": found.condition,
        "pointedness": found.pointedness,
        "mass_ratio": found.mass_ratio,
        "trivial": bool(found.trivial),
    }
