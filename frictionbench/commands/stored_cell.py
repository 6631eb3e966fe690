"""A cell of a results folder that is to be run again. The folder may come from someone else: the cell's data are checked, and
only our own code or plug-ins named in this command are run. A file named in the manifest is shown but never run.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import instances, scenes
from frictionbench.problems.check import require
from frictionbench.problems.schemes import SCHEMES
from frictionbench.problems.spec import split
from frictionbench.results import store
from frictionbench.results.commands import sources
from frictionbench.results.conventions import COLD, WARM, WAYS, json_object
from frictionbench.results.schema import TABLES
from frictionbench.results.store import Row
from frictionbench.solvers import available, find

# Limits within which a solver can be judged: outside, a fault of the folder would be reported as the solver's.
LEAST_SECONDS, MOST_SECONDS = 1e-3, 1e6
LEAST_BYTES, MOST_STEPS, MOST_PROBLEMS = 2**28, 10**6, 10**5  # bytes, steps, problems of a batch


def stored_cell(folder: Path, key: str, tables: Sequence[str] = tuple(TABLES)) -> tuple[str, Row, dict[str, Any], int]:
    """Read the cell of a row: its table, the row with all columns, the settings of its run, and the memory limit in bytes.

    Errors: as for store.find_row, and InputError naming the setting or column that is unusable.
    """
    settings = store.read_manifest(folder)["settings"]
    table, row = store.find_row(folder, key, tables)
    row = dict.fromkeys(column.name for column in TABLES[table]) | row  # shards leave out nulls
    memory = settings.get("memory_limit")
    require(type(memory) is int and LEAST_BYTES <= memory < 2**60, "settings.memory_limit", f"cannot be {memory!r:.100}")
    texts = ("variant", "scene", "verdict", "parameters", *(["scheme"] if table == "simulations" else ["start"]))
    usable = {name: isinstance(row[name], str) for name in texts}
    usable["parameters"] = row["parameters"] == "{}" or bool(json_object(row["parameters"]))
    usable["tol"] = 0 < (row["tol"] or 0) <= 1e300
    usable["time_limit"] = LEAST_SECONDS <= (row["time_limit"] or 0) <= MOST_SECONDS
    if table == "simulations":
        usable["scheme"] = row["scheme"] in SCHEMES
        usable["steps"] = row["steps"] is None or 0 < row["steps"] <= MOST_STEPS
        usable["scene"] = row["scene"] in scenes()
    elif table == "batches":
        usable |= {"way": row["way"] in WAYS, "start": row["start"] in (COLD, WARM)}
        usable["problems"] = type(row["problems"]) is int and 0 < row["problems"] <= MOST_PROBLEMS
        usable["scene"] = row["scene"] in scenes() or row["scene"] in instances()
    elif row["problem"]:
        usable["problem"] = re.fullmatch("[0-9a-f]+", row["problem"]) is not None
    for name, can in usable.items():
        require(can, name, f"cannot be {row[name]!r:.100}")
    return table, row, settings, memory


def trusted(row: Row, settings: dict[str, Any], named: list[str]) -> tuple[Plugin, ...]:
    """Return the named plug-ins that define the row's solver, none for our own solvers.

    Errors: InputError naming the solver and the file from which the run loaded it.
    """
    variant = row["variant"]
    info = available().get(split("solver", variant)[0])
    if info is not None and info.ours:  # plug-ins loaded by this process are not ours
        find(variant)
        return ()
    if not named:
        source = sources(settings).get(variant)
        origin = f"the run loaded it from {source!r}" if source else "the manifest does not name the file"
        raise InputError(f"solver: {variant} is not part of frictionbench; {origin}. To run it, name it with --solver")
    _, plugins = load_plugins(named, (variant,))
    return tuple(plugin for plugin in plugins if variant in plugin.solvers)
