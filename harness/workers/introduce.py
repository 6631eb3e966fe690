"""Plug-ins made known: each file is imported in a worker of its own, which tells what it defines; never in this process."""

import tempfile
from pathlib import Path

from harness.cells import worker
from harness.plans.plan import Plugin
from harness.workers.pool import Pool
from harness.workers.task import Task
from problems import InputError
from solvers import find

MEMORY = 4 * 2**30  # bytes


def introduce(specs: list[str]) -> tuple[tuple[str, ...], tuple[Plugin, ...]]:
    """The variants that the command line names, and the plug-ins among them; a file stands for all the solvers it defines.

    Errors: InputError naming the solver, or the file and its line.
    """
    files = list(dict.fromkeys(str(Path(spec).absolute()) for spec in specs if spec.endswith(".py")))
    named = [spec for spec in specs if not spec.endswith(".py")]
    plugins = tuple(_asked(files, named)) if files else ()
    for spec in named:
        if not any(spec in plugin.solvers for plugin in plugins):
            find(spec)
    variants = [variant for plugin in plugins for variant in plugin.solvers] + named
    for variant in variants:
        if sum(variant in plugin.solvers for plugin in plugins) > 1:
            raise InputError(f"solver: {variant} is defined by two of the files")
    return tuple(dict.fromkeys(variants)), plugins


def _asked(files: list[str], named: list[str]) -> list[Plugin]:
    limit = worker.IMPORTING
    tasks = [Task(path, worker.introduce, (path, named, limit), limit, owner=path) for path in files]
    found = {}
    with tempfile.TemporaryDirectory() as scratch, Pool(Path(scratch), 1, (), MEMORY) as pool:
        for outcome in pool.run(tasks):
            if outcome.death:
                told = outcome.reason.startswith("solver: ")
                raise InputError(
                    outcome.reason if told else f"solver: {outcome.task.name} cannot be imported ({outcome.reason})"
                )
            found[outcome.task.name] = Plugin(**outcome.value)
    return [found[path] for path in files]
