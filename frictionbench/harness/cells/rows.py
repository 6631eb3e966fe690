"""The part of a row that is known before a cell runs, so that a cell that is killed has a row as well."""

import json

from frictionbench.harness import machine
from frictionbench.harness.plans.plan import BatchCell, Plugin, SimulationCell, SolveCell, Source
from frictionbench.results.conventions import COLD
from frictionbench.results.store import Row
from frictionbench.solvers import find

PROBLEM_FACTS = (
    *("problem", "scene", "parameters", "step", "phase", "reference"),
    *("contacts", "dimension", "velocities", "size"),
    *("rank", "condition", "redundancy", "pointedness", "p0_margin", "mass_ratio", "largest_friction"),
    *("asymmetry", "indefiniteness", "islands", "island_ratio"),
    *("trivial", "idle", "sticking", "sliding", "open"),
    *("solutions", "outcomes", "existence", "sensitivity", "mode_distance"),
)


def solve_row(cell: SolveCell, record: Row, limit: float, plugins: tuple[Plugin, ...] = ()) -> Row:
    """The columns of the solve cell, of its problem and of its solver."""
    known = {name: record[name] for name in PROBLEM_FACTS}
    return (
        known
        | _solver_row(cell.variant, plugins)
        | {"key": cell.key, "tol": cell.tol, "time_limit": limit, "start": cell.start}
    )


def no_problem(source: Source, reason: str) -> Row:
    """The record of a source that yields no problem, with the reason, for the rows of its planned cells."""
    parameters = json.dumps(source.parameters, sort_keys=True)
    known = {"problem": "", "scene": source.scene, "parameters": parameters, "step": None, "phase": "", "reference": ""}
    return dict.fromkeys(PROBLEM_FACTS) | known | {"starts": {COLD: ""}, "reason": reason}


def simulation_row(cell: SimulationCell, limit: float, plugins: tuple[Plugin, ...] = ()) -> Row:
    """The columns of the simulation cell and of its solver."""
    return _cell_row(cell, limit, plugins) | {"scheme": cell.scheme, "after_failure": cell.after, "steps": cell.steps}


def batch_row(cell: BatchCell, limit: float, plugins: tuple[Plugin, ...] = ()) -> Row:
    """The columns of the batch cell and of its solver."""
    return _cell_row(cell, limit, plugins) | {"problems": cell.count, "way": cell.way, "start": cell.start}


def _cell_row(cell: SimulationCell | BatchCell, limit: float, plugins: tuple[Plugin, ...]) -> Row:
    """The columns of a cell that is not of one stored problem, and of its solver."""
    facts = {
        "key": cell.key,
        "scene": cell.scene,
        "parameters": json.dumps(cell.parameters, sort_keys=True),
        "tol": cell.tol,
        "time_limit": limit,
    }
    return facts | _solver_row(cell.variant, plugins)


def _solver_row(variant: str, plugins: tuple[Plugin, ...]) -> Row:
    described = next((plugin.solvers[variant] for plugin in plugins if variant in plugin.solvers), None)
    return {"variant": variant, "host": machine.host(), **(described or solver_facts(variant))}


def solver_facts(variant: str) -> Row:
    """The columns of a row that describe a solver, our own or one of a loaded plug-in."""
    info, _ = find(variant)
    return {
        "solver": info.name,
        "family": info.family,
        "model": info.model,
        "members": ", ".join(info.members),
        "version": info.version or machine.revision(),
    }
