"""The plan for the options of `run`, which come from the command line, a TOML file or the manifest of another run.

    suite = "smoke"
    solver = ["lemke", "nsgs[relaxation=1.3]"]
    tol = "1e-4,1e-8"
    time_limit = 2.0

A run stores the options that it was given, except `out`, in its manifest as `options`, so that it can be repeated.
"""

import tomllib
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass

from frictionbench.harness.plans.plan import BatchSource, Plan, Plugin, Source
from frictionbench.harness.plans.recorded import every, with_data
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import instances, near, require_known
from frictionbench.problems.check import require
from frictionbench.problems.spec import parse, split
from frictionbench.results import store
from frictionbench.results.conventions import DRAWN
from frictionbench.results.files import ResultsError, read_text
from frictionbench.solvers.plugins import defines_all, installed

COUNT = 100  # problems in a batch named on the command line
LARGEST_FILE = 2**20  # bytes of a file with options
FileName = Annotated[str, Field(pattern=r"^[^\x00]+$")]


@dataclass(frozen=True, config=ConfigDict(strict=True))
class RunOptions:
    """The options under their names on the command line; None for an option that was not given."""

    suite: str | None = None
    scene: list[str] | None = None
    solver: list[str] | None = None
    tol: str | None = None
    time_limit: float | None = None
    data: list[FileName] | None = None
    all_solvers: bool | None = None
    out: FileName | None = None

    def given(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if value is not None}

    def before(self, other: "RunOptions") -> "RunOptions":
        """Return these options, completed by those of another."""
        return replace(other, **self.given())


def read_options(path: Path, solvers: list[str] | None = None) -> RunOptions:
    """Read the options in a TOML file, or of the run in a results folder.

    Solvers that are code, that is files, commands or installed plug-ins, are refused unless the command line names `solvers`.
    Errors: InputError naming the file and the option, OSError, and those of store.read_manifest.
    """
    try:
        stored = store.read_manifest(path).get("options", {}) if path.is_dir() else tomllib.loads(read_text(path, LARGEST_FILE))
    except ResultsError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(f"config: {path}: {error}") from None
    names = [field.name for field in fields(RunOptions)]
    for name in stored:
        known = f"{path}: unknown option {name!r}{near(name, names)}; known are {', '.join(names)}"
        require(name in names, "config", known)
    try:
        options = RunOptions(**stored)
    except ValidationError as error:
        name, expected = str(error.errors()[0]["loc"][0]), error.errors()[0]["msg"].replace("Input should be", "expected")
        raise InputError(f"config: {path}: {name}: {expected}, got {stored[name]!r:.100}") from None
    points = installed() if options.solver and not solvers else {}
    for spec in () if solvers else options.solver or ():
        code = defines_all(spec) or split("solver", spec)[0] in points
        require(not code, "config", f"{path}: solver: {spec} is code; name it with --solver")
    return options


def choose(wanted: RunOptions, variants: tuple[str, ...] = (), plugins: tuple[Plugin, ...] = ()) -> Plan:
    """Return the suite's plan with its scenes, solvers and settings replaced by the options given.

    variants, plugins: those that the option `solver` names. Errors: InputError naming the field."""
    suite = wanted.suite or "standard"
    require(suite in SUITES, "suite", f"unknown suite {suite!r}{near(suite, SUITES)}; known are {', '.join(SUITES)}")
    require(not (wanted.data and wanted.scene), "data", "names the problems to run, and so does --scene; give one of the two")
    if wanted.all_solvers and variants:
        raise InputError("all-solvers: runs every solver, and --solver names some; give one of the two")
    plan = with_data(SUITES[suite](), tuple(wanted.data or ()))
    if wanted.scene:
        plan = _restricted(plan, wanted.scene)
    if variants:
        plan = replace(plan, solvers=variants, spatial_solvers=(), simulation_solvers=variants, plugins=plugins, expects="")
    if wanted.all_solvers:  # all that are installed, by dimension
        plan = replace(plan, solvers=every(2), spatial_solvers=every(3), simulation_solvers=every(2), expects="")
    if wanted.tol is not None:
        plan = replace(plan, tolerances=_tolerances(wanted.tol))
    if wanted.time_limit is not None:
        plan = replace(plan, time_limit=wanted.time_limit)
    return replace(plan, options=replace(wanted, out=None).given())


def _restricted(plan: Plan, specs: list[str]) -> Plan:
    """Return the plan with only its parts of these names. A spec that has settings, or that names no part, makes new parts."""
    chosen: dict[str, list[Any]] = {"sources": [], "simulations": [], "maps": [], "batches": []}
    for spec in specs:
        name, settings = parse("scene", spec)
        named = {
            kind: [part for part in getattr(plan, kind) if name in (part.scene, getattr(part, "name", None))] for kind in chosen
        }
        if settings or not (named["sources"] or named["maps"] or named["batches"]):
            named = _new(name, settings, bool(plan.batches))
        for kind, each in named.items():
            chosen[kind] += each
    parts: Any = {kind: tuple(each) for kind, each in chosen.items()}
    return replace(plan, expects="", **parts)


def _new(name: str, settings: dict[str, Any], batch: bool) -> dict[str, list[Any]]:
    """Make the parts of a plan from a name and settings. batch: whether to make a batch of COUNT problems.

    Errors: InputError naming the unknown scene or setting, or if a scene for a batch lacks a parameter that is drawn.
    """
    require_known(name, settings)
    if not batch:
        motion = [] if name in instances() else [Source(name, settings)]
        return {"sources": [Source(name, settings, pick=6 if motion else 0)], "simulations": motion}
    try:
        require_known(name, dict.fromkeys(DRAWN, 1.0) | settings)
    except InputError:
        lacks = f"{name} cannot be a batch: its problems differ by {', '.join(DRAWN)}, and it has not all of them"
        raise InputError(f"scene: {lacks}") from None
    return {"batches": [BatchSource(name, settings, COUNT)]}


def _tolerances(text: str) -> tuple[float, ...]:
    """Parse numbers separated by commas, each once. Errors: InputError naming `tol`."""
    try:
        return tuple(dict.fromkeys(float(part) for part in text.split(",")))
    except ValueError:
        raise InputError(f"tol: cannot read {text!r}; write numbers like 1e-4,1e-8") from None
