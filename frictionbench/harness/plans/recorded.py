"""Plans for problems recorded by others, and for spatial instances: every solver that accepts them.

The command line gives the location of recorded problems: `--data DIR`, or `--data fclib/Capsules` for a family downloaded by
`frictionbench export`. Files in a folder whose names differ only in one number are the steps of a sequence, in the order of
that number. Each is started cold, and warm from the answer of the previous step (harness.cells.collect).
"""

import os
import re
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

from frictionbench.harness.plans import families
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.problems.check import require
from frictionbench.problems.recorded import collection, fclib
from frictionbench.results.conventions import COLD, WARM
from frictionbench.solvers import available, find

RECORDED, REPLAY = "recorded", "replay"  # the suites that accept recorded problems
LADDER = (1e-4, 1e-6, 1e-8)  # tolerances, from those that simulations need to those that exact methods reach
FORMATS = (*fclib.SUFFIXES, ".dat", ".npz")  # suffixes of files that problems.recorded reads

# Motions in space with closed forms, those of the battery of engines (tools/battery).
PHENOMENA = (
    Source("sliding_box", {"slope": 0.35, "speed": 0.0}),  # held by friction: it must not creep
    Source("sliding_box", {"heading": 0.5}),  # slides in a straight line until it stops
    Source("sliding_box", {"slope": 0.24, "speed": 0.0, "aspect": 4.0, "friction": 1.0}),  # about to tip over
    Source("box_tower"),
    Source("box_tower", {"boxes": 2, "mass_ratio": 1000.0}),
    Source("box_in_groove"),
    Source("sliding_ball"),
    *(Source("dropped_ball", {"restitution": e, "step": 0.01}) for e in (0.0, 0.5, 1.0)),
)

# Our methods for Coulomb's law that are the fastest on some kind of problem; --all-solvers adds the others.
WINNERS = ("hybrid", "lemke", "path_search", "interior_point", "nsgs", "nncg")
SPATIAL_WINNERS = ("hybrid", "interior_point", "nsgs", "nncg", "proximal_newton", "apgd_coulomb")


def every(dimension: int) -> tuple[str, ...]:
    """Return all installed solvers that accept problems of this dimension, ours before those of outside libraries."""
    ours = (spec for _, info in sorted(available().items()) if not info.needs for spec in info.specs)
    specs = tuple(spec for spec in ours if dimension in find(spec)[0].dimension)
    return (*specs, *installed(*theirs(dimension)))


def installed(*specs: str) -> tuple[str, ...]:
    """Return the solvers of which every required package is installed."""
    return tuple(spec for spec in specs if not find(spec)[0].missing)


def theirs(dimension: int) -> tuple[str, ...]:
    """Return all solvers of outside libraries, installed or not, that accept problems of this dimension."""
    specs = (spec for _, info in sorted(available().items()) if info.needs for spec in info.specs)
    return tuple(spec for spec in specs if dimension in find(spec)[0].dimension)


def recorded() -> Plan:
    """Recorded problems in a folder or a fetched family (--data DIR|fclib/FAMILY), with the solvers that can be the fastest, or
    with --all-solvers every installed one."""
    return Plan(
        suite=RECORDED,
        sources=(),
        solvers=WINNERS,
        spatial_solvers=SPATIAL_WINNERS,
        tolerances=LADDER,
        starts=(COLD, WARM),  # warm: from the initial guess of a file that has one
    )


def spatial() -> Plan:
    """Spatial problems of one step, from one contact to a thousand, and motions with solutions in closed form, with every
    solver that accepts them."""
    large = (
        Source("cubes", {"boxes": 100, "push": 0.1, "twist": 1.0, "smooth": 0.2, "fall": 1.0}),
        Source("sphere_pyramid", {"levels": 6, "friction": 0.5}),  # between sliding and sticking, where it is hardest
        Source("packed_spheres", {"spheres": 250, "friction": 0.1}),
        Source("random_bodies", {"contacts": 1000, "seed": 2}),
        Source("rod_chain", {"links": 200, "pull": 0.05, "whirl": 0.2}),
    )
    lineup = every(3)
    return Plan(
        suite="spatial",
        sources=(*families.halves(*families.SPACE), *large),
        solvers=lineup,
        tolerances=(1e-4, 1e-8),
        simulations=PHENOMENA,
        simulation_solvers=lineup,
        time_limit=2.0,
        simulation_limit=10.0,
        expects="twenty-five minutes",
    )


def with_data(plan: Plan, locations: tuple[str, ...]) -> Plan:
    """Return the plan with its problems replaced by the recorded problems at these locations.

    Errors: InputError naming `data` or the family.
    """
    needed = f"{RECORDED} needs --data DIR, or --data fclib/FAMILY after `frictionbench export fclib/FAMILY`"
    require(bool(locations) or plan.suite != RECORDED, "data", needed)
    own = f"{plan.suite} has problems of its own; recorded ones are run by {RECORDED}, {REPLAY}"
    require(not locations or plan.suite in (RECORDED, REPLAY), "data", own)
    found = {source.file: source for location in locations for source in located(location)}
    names: dict[tuple[str, str], str] = {}
    for file, source in found.items():
        other = names.setdefault((source.scene, source.parameters["file"]), file)
        require(other == file, "data", f"{other} and {file} would be one problem of {source.scene}; rename a folder or a file")
    return replace(plan, sources=tuple(found.values())) if locations else plan


def located(location: str) -> list[Source]:
    """Return the recorded problems of a file, a folder or a fetched family. Errors: InputError naming `data` or the family."""
    if location.startswith("fclib/"):
        family = collection.family(location)
        folder = collection.cache_folder() / family
        files, steps = sorted(_files(folder)), {}  # FCLIB selects problems from simulations: they are no sequence
        missing = f"; fetch it with `frictionbench export {location}`"
    else:
        place = Path(location).resolve()
        folder, family = place.parent if place.is_file() else place, place.name
        files = [place] if place.is_file() else sorted(_files(folder), key=natural)
        steps = _steps(files)
        missing = f": no {', '.join(FORMATS)} file" if place.exists() else ": there is no such folder"
    require(bool(files), "data", f"no problems in {location}{missing}")
    return [Source(family, {"file": str(path.relative_to(folder))}, file=str(path), **steps.get(path, {})) for path in files]


def _files(folder: Path) -> list[Path]:
    """Return the files below a folder, not those of results, that may hold problems. Errors: OSError if one cannot be read."""

    def refuse(error: OSError) -> None:
        raise error

    paths: list[Path] = []
    for place, below, names in os.walk(folder, onerror=refuse) if folder.exists() else ():
        if "manifest.json" in names and Path(place) != folder:
            below.clear()
        else:
            paths += [Path(place, name) for name in names]
    return [path for path in paths if path.suffix in FORMATS and not path.name.startswith(".") and path.is_file()]


def natural(path: Path) -> tuple[str | int, ...]:
    """Return a key that sorts step_2 before step_10."""
    return tuple(int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", str(path)))


def _steps(files: list[Path]) -> dict[Path, dict[str, Any]]:
    """Return, for the files that are steps of a sequence, the number of the step and the file of the previous step.

    A sequence is a folder of several files whose names differ only in one number.
    """
    steps = {}
    for _, group in groupby(files, key=lambda path: path.parent):
        members = list(group)
        names = [natural(Path(path.name)) for path in members]
        differ = [i for i, parts in enumerate(zip(*names, strict=False)) if len({*parts}) > 1]
        if len({len(name) for name in names}) == len(differ) == 1 and isinstance(names[0][differ[0]], int):
            for step, path in enumerate(members):
                steps[path] = {"step": step, "before": str(members[step - 1]) if step else ""}
    return steps
