"""A cell of a results folder that is to run again, which may come from someone else: what it needs is checked, and its code is
our own or that of plug-ins that the user names in this command. The file named in the manifest is shown and never run.
"""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scenes
from frictionbench.problems.check import require
from frictionbench.problems.instances import instances
from frictionbench.problems.schemes import require_scheme
from frictionbench.problems.spec import split
from frictionbench.results import store
from frictionbench.results.conventions import COLD, KEEP_ANSWER, KEEP_VELOCITY, RELAX, WARM, WAYS
from frictionbench.results.schema import TABLES
from frictionbench.results.store import Row
from frictionbench.solvers import available, find

# Limits within which a solver can be judged: with less than these, a fault of the folder would be told as the solver's.
LEAST_SECONDS, MOST_SECONDS = 1e-3, 1e6
LEAST_MEMORY, MOST_STEPS, MOST_PROBLEMS = 2**28, 10**6, 10**5  # bytes, steps, problems of a batch


class StoredCell(NamedTuple):
    """A row with all columns, its table, and the settings of its run with a memory limit in bytes."""

    table: str
    row: Row
    settings: dict[str, Any]
    memory_limit: int


def stored_cell(folder: Path, key: str, tables: Sequence[str] = tuple(TABLES)) -> StoredCell:
    """The cell of a row. Errors: as of store.find_row, and InputError naming the setting or column that cannot be used."""
    settings = store.read_manifest(folder)["settings"]
    table, row = store.find_row(folder, key, tables)
    row = dict.fromkeys(column.name for column in TABLES[table]) | row  # shards leave out nulls
    memory = settings.get("memory_limit")
    require(type(memory) is int and LEAST_MEMORY <= memory < 2**60, "settings.memory_limit", f"cannot be {memory!r:.100}")
    for name in ("variant", "scene", "verdict", "parameters", *(["scheme"] if table == "simulations" else ["start"])):
        require(isinstance(row[name], str), name, "is missing from the row")
    _positive(row, "tol", 0.0, 1e300)
    _positive(row, "time_limit", LEAST_SECONDS, MOST_SECONDS)
    try:
        parameters = json.loads(row["parameters"])
    except (ValueError, RecursionError):
        parameters = None
    require(isinstance(parameters, dict), "parameters", "not a JSON object")
    if table == "simulations":
        require_scheme(row["scheme"])
        require(
            row["after_failure"] in (KEEP_ANSWER, KEEP_VELOCITY, RELAX),
            "after_failure",
            f"unknown: {row['after_failure']!r:.100}",
        )
        steps = row["steps"]
        require(steps is None or 0 < steps <= MOST_STEPS, "steps", f"cannot be {steps}")
        require(row["scene"] in scenes(), "scene", f"unknown scene {row['scene']!r:.100}")
    elif table == "batches":
        require(
            row["way"] in WAYS and row["start"] in (COLD, WARM),
            "way",
            f"unknown: {row['way']!r:.100} from {row['start']!r:.100}",
        )
        require(
            type(row["problems"]) is int and 0 < row["problems"] <= MOST_PROBLEMS, "problems", f"cannot be {row['problems']}"
        )
        require(row["scene"] in scenes() or row["scene"] in instances(), "scene", f"unknown scene {row['scene']!r:.100}")
    elif row["problem"]:
        require(re.fullmatch("[0-9a-f]+", row["problem"]) is not None, "problem", f"not a hash: {row['problem']!r:.100}")
    return StoredCell(table, row, settings, memory)


def _positive(row: Row, name: str, least: float, most: float) -> None:
    value = row[name]
    require(value is not None and value > 0 and least <= value <= most, name, f"cannot be {value}")


def trusted(row: Row, settings: dict[str, Any], named: list[str]) -> tuple[Plugin, ...]:
    """The named plug-ins that define the row's solver; none for our own solvers.

    Errors: InputError naming the solver, and the file from which the run loaded it.
    """
    variant = row["variant"]
    info = available().get(split("solver", variant)[0])
    if info is not None and info.ours:  # plug-ins loaded by this process are not ours
        find(variant)
        return ()
    if not named:
        raise InputError(
            f"solver: {variant} is not part of frictionbench; {_origin(variant, settings)}. To run it, name it with --solver"
        )
    _, plugins = load_plugins(named, (variant,))
    return tuple(plugin for plugin in plugins if variant in plugin.solvers)


def _origin(variant: str, settings: dict[str, Any]) -> str:
    plugins = settings.get("plugins")
    for plugin in plugins if isinstance(plugins, list) else []:
        if isinstance(plugin, dict) and variant in (plugin.get("solvers") or ()):
            return f"the run loaded it from {plugin.get('source')!r} ({str(plugin.get('content'))[:12]})"
    return "the manifest does not name the file"
