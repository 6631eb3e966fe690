"""Plug-ins and scenes that a user names, which are first imported and built in a worker with its limits.

The main process imports no plug-in, and a scene of a million blocks takes a minute and gigabytes.
"""

import json
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from frictionbench.harness.cells.worker import IMPORT_SECONDS, describe_plugin, run_scene
from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.workers.pool import Task, scratch_pool
from frictionbench.problems import InputError
from frictionbench.problems.spec import split
from frictionbench.results.conventions import scene_title
from frictionbench.results.files import ResultsError, cleaned, parsed
from frictionbench.solvers import find, plugins

COLUMNS = {"solver", "family", "model", "members", "version"}  # columns of harness.cells.rows.solver_facts
BUILD_SECONDS = 60.0  # time limit in seconds for a scene and its first problem: the suites' largest scene takes one


def load_plugins(specs: list[str], wanted: tuple[str, ...] = ()) -> tuple[tuple[str, ...], tuple[Plugin, ...]]:
    """Return the variants that the command line names, and the plug-ins that define them.

    A file and a command of an executable stand for all the solvers that they define.

    wanted: further variants; each must be ours or defined by one of the specs, because it loads no code.
    Errors: InputError naming the solver, or the file and its line.
    """
    files = [plugins.absolute(spec) for spec in specs if plugins.defines_all(spec)]
    named = [spec for spec in specs if not plugins.defines_all(spec)]
    heads = {split("solver", spec)[0] for spec in named}
    sources = list(dict.fromkeys([*files, *(name for name in plugins.installed() if name in heads)])) if specs else []
    named += wanted
    loaded = tuple(_load(sources, named)) if sources else ()
    if loaded and os.geteuid() == 0:
        print("frictionbench: plug-ins run with root's rights, which no sandbox takes from them in full", file=sys.stderr)
    for spec in named:
        if not any(spec in plugin.solvers for plugin in loaded):
            find(spec)
    variants = [variant for plugin in loaded for variant in plugin.solvers] + named
    for variant in variants:
        if sum(variant in plugin.solvers for plugin in loaded) > 1:
            raise InputError(f"solver: {variant} is defined by two plug-ins; give one of them")
    return tuple(dict.fromkeys(variants)), loaded


def _load(sources: list[str], named: list[str]) -> list[Plugin]:
    contents = {source: plugins.content(source) for source in sources}  # before any of them can change another
    tasks = [Task(describe_plugin, (source, named), IMPORT_SECONDS, owner=source) for source in sources]
    with scratch_pool() as pool:
        values = {done.task.owner: done.result(f"solver: {done.task.owner} cannot be imported") for done in pool.run(tasks)}
    if changed := [source for source in sources if plugins.content(source) != contents[source]]:
        raise InputError(f"solver: {changed[0]} was changed while plug-ins were imported")
    return [_described(source, values[source]) for source in sources]


def _described(source: str, value: Any) -> Plugin:
    """Check a worker's description of a plug-in. Errors: InputError if it is malformed, since a plug-in may reply anything."""
    with suppress(ResultsError):
        plugin = parsed(value, Plugin, source)
        named = (plugin.source, plugin.content) == (cleaned(source), plugins.content(source))
        if named and all(facts.keys() == COLUMNS for facts in plugin.solvers.values()):
            return replace(plugin, source=source)
    raise InputError(f"solver: {source} cannot be imported (its worker returned a malformed description)")


def require_buildable(chosen: Sequence[tuple[str, dict[str, Any]]]) -> None:
    """Build each of these scenes and instances, by name and parameters, in a worker.

    Errors: InputError naming the parameter, or the scene if it takes too much memory or time.
    """
    tasks = [Task(run_scene, scene, BUILD_SECONDS) for scene in chosen]
    with scratch_pool() as pool:
        for outcome in pool.run(tasks):
            name, parameters = outcome.task.arguments
            outcome.result(f"scene: {scene_title(name, json.dumps(parameters))} cannot be made")
