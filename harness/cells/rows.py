"""The part of a row that is known before a cell runs, so that a cell that is killed leaves a row too."""

import json

from frictionbench.harness import machine
from frictionbench.harness.plans.plan import Plugin, SimulationCell, SolveCell, Source
from frictionbench.results.conventions import COLD
from frictionbench.results.store import Row
from frictionbench.solvers import find

PROBLEM_FACTS = (
    *("problem", "scene", "parameters", "step", "phase", "reference"),
    *("contacts", "dimension", "velocities", "size"),
    *("rank", "condition", "redundancy", "pointedness", "p0_margin", "mass_ratio", "asymmetry", "indefiniteness", "trivial"),
    *("solutions", "outcomes", "existence", "sensitivity", "mode_distance"),
)


def solve_row(cell: SolveCell, entry: Row, limit: float, plugins: tuple[Plugin, ...] = ()) -> Row:
    """The solve cell, the facts of its problem and of its solver."""
    known = {name: entry[name] for name in PROBLEM_FACTS}
    return (
        known
        | _solver_row(cell.variant, plugins)
        | {"key": cell.key, "tol": cell.tol, "time_limit": limit, "start": cell.start}
    )


def nothing(source: Source, reason: str) -> Row:
    """The facts of a source that yields no problem, for a row that says so of each of its planned cells."""
    parameters = json.dumps(source.parameters, sort_keys=True)
    known = {"problem": "", "scene": source.scene, "parameters": parameters, "step": None, "phase": "", "reference": ""}
    return dict.fromkeys(PROBLEM_FACTS) | known | {"starts": [COLD], "reason": reason}


def simulation_row(cell: SimulationCell, limit: float, plugins: tuple[Plugin, ...] = ()) -> Row:
    """The simulation cell and the facts of its solver."""
    facts = {
        "key": cell.key,
        "scene": cell.scene,
        "parameters": json.dumps(cell.parameters, sort_keys=True),
        "scheme": cell.scheme,
        "after_failure": cell.after,
        "steps": cell.steps,
        "tol": cell.tol,
        "time_limit": limit,
    }
    return facts | _solver_row(cell.variant, plugins)


def _solver_row(variant: str, plugins: tuple[Plugin, ...]) -> Row:
    told = next((plugin.solvers[variant] for plugin in plugins if variant in plugin.solvers), None)
    return {"variant": variant, "host": machine.host(), **(told or solver_facts(variant))}


def solver_facts(variant: str) -> Row:
    """What a row says of a solver, of our own or of a plug-in that is loaded."""
    info, _ = find(variant)
    return {
        "solver": info.name,
        "family": info.family,
        "model": info.model,
        "members": ", ".join(info.members),
        "version": info.version or machine.revision(),
    }
