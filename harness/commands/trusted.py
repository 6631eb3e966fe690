"""Whose code a row of a results folder may run again: ours, and of plug-ins those that the user names in this command.

A results folder may come from anybody. The file that its manifest names is told, never run.
"""

from typing import Any

from harness.plans.plan import Plugin
from harness.workers.introduce import introduce
from problems import InputError
from problems.spec import split
from results.store import Row
from solvers import available, find


def trusted(row: Row, settings: dict[str, Any], files: list[str]) -> tuple[Plugin, ...]:
    """The plug-ins among the user's files that the row's solver needs; none for our own.

    Errors: InputError naming the solver, and the file that the run had it from.
    """
    variant = row["variant"]
    if split("solver", variant)[0] in available():
        find(variant)
        return ()
    if not files:
        raise InputError(f"solver: {variant} is not ours; {_origin(variant, settings)}. Give its file with --solver to run it")
    _, plugins = introduce([*files, variant])
    return tuple(plugin for plugin in plugins if variant in plugin.solvers)


def _origin(variant: str, settings: dict[str, Any]) -> str:
    plugins = settings.get("plugins")
    for plugin in plugins if isinstance(plugins, list) else []:
        if isinstance(plugin, dict) and variant in (plugin.get("solvers") or ()):
            return f"the run had it from {plugin.get('path')!r} ({str(plugin.get('content'))[:12]})"
    return "the run does not say where it had it from"
