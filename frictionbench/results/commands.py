"""The commands that reports and the command line suggest to a reader, complete with the options that they need: a plug-in's
solver is known only if its file or installed name is given."""

import os
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

Sources = Mapping[str, str]  # the file or installed name of a plug-in, by variant


def sources(settings: Mapping[str, Any]) -> dict[str, str]:
    """Return the plug-ins of a run by variant, from the settings in its manifest."""
    return {variant: plugin["source"] for plugin in settings.get("plugins", ()) for variant in plugin["solvers"]}


def rerun(folder: Path, key: str, variant: str, plugins: Sources) -> str:
    """Return the command that runs a cell again."""
    return shlex.join(["frictionbench", "rerun", str(folder), key, *_plugin(variant, plugins)])


def solve(problem: Path | str, variant: str, tol: float, plugins: Sources) -> str:
    """Return the command that solves a problem, which is a file or a scene, with a variant and a tolerance."""
    named = [] if variant in plugins and "[" not in variant else ["--solver", variant]
    options = [*_plugin(variant, plugins), *named, "--tol", f"{tol:g}"]
    return shlex.join(["frictionbench", "solve", str(problem), *options])


def _plugin(variant: str, plugins: Sources) -> list[str]:
    source = plugins.get(variant, "")
    return ["--solver", os.path.relpath(source) if Path(source).is_absolute() else source] if source else []
