"""Whose code a row of a results folder may run again: ours, and of plug-ins those that the user names in this command.

A results folder may come from anybody. The file that its manifest names is told, never run.
"""

from typing import Any

from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.workers.plugins import load_plugins
from frictionbench.problems import InputError
from frictionbench.problems.spec import split
from frictionbench.results.store import Row
from frictionbench.solvers import available, find


def trusted(row: Row, settings: dict[str, Any], named: list[str]) -> tuple[Plugin, ...]:
    """The plug-ins that the user named and the row's solver needs; none for our own.

    Errors: InputError naming the solver, and the file that the run had it from.
    """
    variant = row["variant"]
    info = available().get(split("solver", variant)[0])
    if info is not None and info.ours:  # not one that this process has loaded as a plug-in
        find(variant)
        return ()
    if not named:
        raise InputError(f"solver: {variant} is not ours; {_origin(variant, settings)}. Give that with --solver to run it")
    _, plugins = load_plugins(named, (variant,))
    return tuple(plugin for plugin in plugins if variant in plugin.solvers)


def _origin(variant: str, settings: dict[str, Any]) -> str:
    plugins = settings.get("plugins")
    for plugin in plugins if isinstance(plugins, list) else []:
        if isinstance(plugin, dict) and variant in (plugin.get("solvers") or ()):
            return f"the run had it from {plugin.get('source')!r} ({str(plugin.get('content'))[:12]})"
    return "the run does not say where it had it from"
