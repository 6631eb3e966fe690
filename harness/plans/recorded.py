"""Plans for problems recorded by others, and for spatial instances: every solver that accepts them.

The command line gives the location of recorded problems: `--data DIR`, or `--data fclib/Capsules` for a family that
`frictionbench fetch` has downloaded. Files of a folder whose names differ in one number alone are the steps of a sequence, in
the order of that number; each is started cold, and warm from the answer of the step before (harness.cells.collect).
"""

import re
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

from frictionbench.harness.plans.lineups import EXACT, LADDER, OTHERS, RELAXED
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.problems import InputError
from frictionbench.problems.recorded import collection
from frictionbench.results.conventions import COLD, WARM

REPLAY = "replay"  # the suite of motions, which takes recorded ones as well
FORMATS = (".hdf5", ".h5", ".dat", ".npz")  # suffixes of files that problems.recorded reads

# Accuracy and time limit of Acary, Brémond and Huber 2018, family by family of the collection.
ABH2018 = {
    "Global/LMGC90/cubes_H8": (1e-8, 100.0),
    "Local/LMGC90/Cubes_H8": (1e-8, 100.0),
    "Local/LMGC90/LowWall_FEM": (1e-8, 400.0),
    "Local/LMGC90/Aqueduct_PR": (1e-4, 200.0),
    "Local/LMGC90/Bridge_PR": (1e-8, 400.0),
    "Local/LMGC90/100_PR_PerioBox": (1e-4, 100.0),
    "Local/LMGC90/945_SP_Box_PL": (1e-4, 100.0),
    "Local/siconos/Capsules": (1e-8, 50.0),
    "Local/siconos/Chain": (1e-8, 50.0),
    "Local/siconos/KaplasTower": (1e-8, 200.0),
    "Local/siconos/BoxesStack": (1e-8, 100.0),
    "Local/siconos/Chute_1000": (1e-4, 200.0),
    "Local/siconos/Chute_4000": (1e-4, 200.0),
}


def recorded() -> Plan:
    """Recorded problems, of a folder or a fetched family (--data DIR|fclib/FAMILY), with every solver that accepts them."""
    return Plan(
        suite="recorded",
        sources=(),
        solvers=(*EXACT, *OTHERS, "relaxation_ip", *RELAXED),
        tolerances=LADDER,
        starts=(COLD, WARM),  # warm: from the initial guess of a file that has one
        time_limit=10.0,
    )


def abh2018() -> Plan:
    """Families of Acary, Brémond and Huber 2018 at the paper's accuracies and limits (--data fclib/FAMILY, or all fetched)."""
    return replace(recorded(), suite="abh2018", tolerances=(1e-4, 1e-8))


def spatial() -> Plan:
    """Spatial problems of one step, from one contact to a thousand, with every solver that accepts them."""
    boxes = [{"boxes": n, "friction": mu, "push": push} for n in (1, 3, 10, 30, 100) for mu, push in ((0.5, 0.0), (0.2, 1.0))]
    heavy = [{"boxes": 10, "push": 1.0, "mass_ratio": ratio} for ratio in (1e2, 1e4)]
    piles = [{"levels": n, "friction": mu, "noise": 0.03} for n in (2, 4, 6) for mu in (0.2, 0.7)]
    piles += [
        {"levels": n, "friction": 0.5} for n in (4, 5, 6)
    ]  # between friction at which it slides and at which it sticks: the hardest
    packings = [{"spheres": n, "friction": mu, "fraction": 0.64} for n in (10, 50, 250) for mu in (0.1, 0.7)]
    scattered = [{"contacts": n, "seed": seed} for n in (2, 10, 50, 300) for seed in (0, 1)]
    extreme = [
        {"contacts": 40, "seed": seed, name: value}
        for seed in (0, 1)
        for name, value in (("friction", 1e3), ("mass_ratio", 1e6))
    ]
    kinds: dict[str, list[dict[str, Any]]] = {
        "cubes": [*boxes, *heavy],
        "sphere_pyramid": piles,
        "packed_spheres": packings,
        "random_bodies": [*scattered, *extreme],
    }
    return Plan(
        suite="spatial",
        sources=tuple(Source(name, grid) for name, grids in kinds.items() for grid in grids),
        solvers=(*EXACT, *(f"lemke[facets={k}]" for k in (4, 16, 64)), *OTHERS, "relaxation_ip", "ccp_cone"),
        tolerances=LADDER,
        time_limit=10.0,
    )


def with_data(plan: Plan, locations: list[str]) -> Plan:
    """The plan with the recorded problems at these locations, in place of its own.

    Errors: InputError naming `data` or the family.
    """
    names = [suite().suite for suite in (recorded, abh2018)]
    of_the_paper = plan.suite == abh2018().suite
    if of_the_paper and not locations:
        locations = [f"fclib/{family}" for family in collection.fetched() if family in ABH2018]
    if not locations:
        if plan.suite in names:
            needed = "--data DIR, or --data fclib/FAMILY after `frictionbench fetch fclib/FAMILY`"
            raise InputError(f"data: {plan.suite} needs {needed}")
        return plan
    takers = (*names, REPLAY)
    if plan.suite not in takers:
        raise InputError(f"data: {plan.suite} has problems of its own; recorded ones are run by {', '.join(takers)}")
    found = [source for location in locations for source in _sources(location, of_the_paper)]
    return replace(plan, sources=tuple(found))


def _sources(location: str, of_the_paper: bool) -> list[Source]:
    if location.startswith("fclib/"):
        family = collection.family(location)
        folder = collection.folder(family)
        accuracy, limit = ABH2018.get(family, (None, None)) if of_the_paper else (None, None)
        own: dict[str, Any] = {} if accuracy is None else {"tolerances": (accuracy,), "time_limit": limit}
        files, steps = sorted(_files(folder)), {}  # a selection from simulations, no sequence
        missing = f"no problems in {location}; fetch it with `frictionbench fetch {location}`"
    else:
        place, own = Path(location).resolve(), {}
        folder = place.parent if place.is_file() else place
        family = place.name
        files = [place] if place.is_file() else sorted(_files(folder), key=_natural)
        steps = _steps(files)
        missing = f"no problems in {location}: " + (
            "it is no folder" if not place.exists() else f"no {', '.join(FORMATS)} file"
        )
    if not files:
        raise InputError(f"data: {missing}")
    return [
        Source(family, {"file": str(path.relative_to(folder))}, file=str(path), **own, **steps.get(path, {})) for path in files
    ]


def _files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.suffix in FORMATS and path.is_file()]


def _natural(path: Path) -> tuple[str | int, ...]:
    """A key that sorts step_2 before step_10."""
    return tuple(int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", str(path)))


def _steps(files: list[Path]) -> dict[Path, dict[str, Any]]:
    """Of the files that are steps of a sequence, the number of the step and the file of the step before.

    A sequence is a folder of several files whose names differ in one number alone.
    """
    steps = {}
    for _, group in groupby(files, key=lambda path: path.parent):
        members = list(group)
        names = [_natural(Path(path.name)) for path in members]
        differ = [i for i, parts in enumerate(zip(*names, strict=False)) if len({*parts}) > 1]
        if len({len(name) for name in names}) == len(differ) == 1 and isinstance(names[0][differ[0]], int):
            for step, path in enumerate(members):
                steps[path] = {"step": step, "before": str(members[step - 1]) if step else ""}
    return steps
