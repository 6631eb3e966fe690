"""The options of `run` that choose a plan: from the command line, a TOML file, or the manifest of a run.

    suite = "smoke"
    solver = ["lemke", "nsgs[relaxation=1.3]"]
    tol = "1e-4,1e-8"
    time_limit = 2.0

A run writes those that it was given, but `out`, into its manifest as `options`, from which another can be made like it.
"""

import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from frictionbench.problems import InputError
from frictionbench.problems.catalogue import near
from frictionbench.problems.check import require
from frictionbench.results import store
from frictionbench.solvers.plugins import defines_all


class RunOptions(NamedTuple):
    """The options by their names on the command line; None for one that was not given."""

    suite: str | None = None
    scene: list[str] | None = None
    solver: list[str] | None = None
    tol: str | None = None
    time_limit: float | None = None
    data: list[str] | None = None
    all_solvers: bool | None = None
    out: str | None = None

    def given(self) -> dict[str, Any]:
        return {name: value for name, value in self._asdict().items() if value is not None}

    def before(self, other: "RunOptions") -> "RunOptions":
        """These options, and those of another where they are not given."""
        return other._replace(**self.given())


_TEXT, _TEXTS = (str,), (list,)
_KINDS: dict[str, tuple[type, ...]] = {
    "suite": _TEXT,
    "scene": _TEXTS,
    "solver": _TEXTS,
    "tol": _TEXT,
    "out": _TEXT,
    "data": _TEXTS,
}
_KINDS |= {"time_limit": (int, float), "all_solvers": (bool,)}


def read_options(path: Path) -> RunOptions:
    """The options in a TOML file, or of the run in a results folder.

    Solvers that are code, a file or a command, are refused: they are named on the command line.
    Errors: InputError naming the file and the option, OSError, and as of store.read_manifest.
    """
    try:
        found = store.read_manifest(path).get("options", {}) if path.is_dir() else tomllib.loads(path.read_text("utf-8"))
    except ValueError as error:
        raise InputError(f"config: {path}: {error}") from None
    require(isinstance(found, dict), "config", f"{path}: options: not a table")
    for name, value in found.items():
        known = f"{path}: unknown option {name!r}{near(name, _KINDS)}; known are {', '.join(_KINDS)}"
        require(name in _KINDS, "config", known)
        texts = not isinstance(value, list) or all(isinstance(each, str) for each in value)
        require(type(value) in _KINDS[name] and texts, "config", f"{path}: {name}: cannot be {value!r:.100}")
    for spec in found.get("solver", []):
        require(not defines_all(spec), "config", f"{path}: solver: {spec} is code; name it with --solver")
    return RunOptions(**found)
