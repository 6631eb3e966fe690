"""The code that a row of a results folder may run again: our own, and the plug-ins that the user names in this command.

A results folder may come from someone else. The file named in its manifest is shown to the user and never run.
"""

from typing import Any

from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import InputError
from frictionbench.problems.spec import split
from frictionbench.results.store import Row
from frictionbench.solvers import available, find


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
