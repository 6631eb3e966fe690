"""The suite `hard`, which ranks robustness: problems with a known solution on which at least one serious method fails.

The candidates are families at their edges. The families, their grids and FEWEST were settled after a look at which problems
fail, so that there are enough; which candidates are in the suite follows from a run of all methods at one tolerance:

    python -m tools.admit DIR     runs the candidates in DIR, or goes on, and writes hard.tsv

A candidate is *admissible* if a solution is known (by a theorem, see problems.analysis.thresholds, by counting all solutions,
or because a verified answer is one, which is then kept in hard.npz), if friction is at work (it is neither trivial nor idle),
and if the rounding floor of its best answer is at most a tenth of the tolerance. A method *fails* on it if it ends with a
verdict other than `solved`; a timeout does not count, since it depends on the machine, and neither does an LCP in space, which
is another model. Of each family and for each method the suite has the FEWEST admissible candidates with the fewest contacts on
which the method fails.

The rule treats all methods alike. But the problems were chosen by their failures: a method's share solved in this suite says on
what it fails, not how often it fails in general.
"""

import csv
import json
from collections.abc import Iterable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.problems.check import Array
from frictionbench.problems.instances.recorded_step import recorded_steps

# One or two of every kind of method for Coulomb's law that simulators and libraries are built on.
METHODS = (
    *("lemke", "dantzig", "path_search", "fischer_newton"),  # in the plane, where the friction LCP is Coulomb's law
    *("hybrid", "interior_point", "nsgs", "proximal_newton"),
)
TOL = 1e-8
LIMIT = 10.0  # seconds
FEWEST = 4
ADMITTED, ANSWERS = (Path(__file__).with_name(f"hard.{suffix}") for suffix in ("tsv", "npz"))


def hard() -> Plan:
    """Problems on which at least one serious method fails, to compare robustness."""
    return Plan(
        suite="hard",
        sources=tuple(Source(row["scene"], json.loads(row["parameters"])) for row in admitted()),
        solvers=METHODS[:-1],
        spatial_solvers=METHODS,
        tolerances=(1e-4, TOL),
        time_limit=5.0,
        expects="ten minutes",
    )


def candidates(dimension: int) -> Plan:
    """All candidates of a dimension, with the methods whose model is exact there."""
    return Plan(
        suite=f"candidates for hard, dimension {dimension}",
        sources=tuple(source for family in families(dimension).values() for source in family),
        solvers=METHODS[:-1] if dimension == 2 else METHODS[4:],
        tolerances=(TOL,),
        time_limit=LIMIT,
    )


def families(dimension: int) -> dict[str, list[Source]]:
    """The candidates by family."""
    return _planar() if dimension == 2 else _spatial()


def admitted() -> list[dict[str, str]]:
    """The rows of hard.tsv: family, scene, parameters, contacts, known, residual, floor, answer, failed."""
    with ADMITTED.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def kept_answer(row: dict[str, str]) -> Array | None:
    """The verified impulses (nc, d) kept for a row of hard.tsv; None where a solution is known by theory alone."""
    if not row["answer"]:
        return None
    with np.load(ANSWERS, allow_pickle=False) as answers:
        return answers[answer_key(row)]


def answer_key(row: dict[str, Any]) -> str:
    """The name of a row's answer in hard.npz. row: with scene and parameters."""
    return f"{row['scene']} {row['parameters']}"


def _grid(scene: str, **values: Iterable[Any]) -> list[Source]:
    """A source for every combination of the parameters' values, whose solves are timed once."""
    return [Source(scene, dict(zip(values, chosen, strict=True)), repeats=1) for chosen in product(*values.values())]


def _planar() -> dict[str, list[Source]]:
    seeds, ratios = range(4), (1e4, 1e6, 1e8)
    units = ({"step": 1e-8}, {"step": 1e4}, {"mass_unit": 1e-12}, {"length_unit": 1e9}, {"mass_unit": 1e9, "length_unit": 1e-6})
    return {
        "unlike masses": [
            *_grid("stack", blocks=(2, 5, 10, 20), mass_ratio=(1e3, 1e6, 1e8), push=(1.0,)),
            *_grid("random", contacts=(5, 15, 40), mass_ratio=ratios, seed=seeds),
            *_grid("local_graph", bodies=(30, 100), mass_ratio=ratios),
        ],
        "much friction": [
            *_grid("random", contacts=(4, 12, 40), friction=(10.0, 1e2, 1e4), seed=seeds),
            *_grid("redundant_table", legs=(3, 6), friction=(1.3, 10.0, 1e4), speed=(1.0,)),
        ],
        "around p = 0": [
            *(
                Source("painleve_rod", {"angle": angle, "friction": vanishing_p(angle) * (1 + beyond), "step": 1e-4}, repeats=1)
                for angle in (0.45, 0.8, 1.107)
                for beyond in (-1e-3, -1e-6, 1e-6, 1e-3, 0.1, 0.5)
            ),
            *_grid("two_corner_block", aspect=(0.9, 1.2), friction=(1.0, 2.7, 3.5, 3.9)),
            *_grid("random", contacts=(3, 6), friction=(2.0, 5.0), seed=seeds),
        ],
        "near jam": _grid("slots", points=(2, 5, 15), tilt=(1e-2, 0.3, 1.5), excess=(-1e-6, 1.0), seed=(0, 1)),
        "hyperstatic": [
            *_grid("stack", blocks=(5, 10, 20, 40, 80), push=(1.0,), friction=(0.05, 0.8)),
            *_grid("pyramid", rows=(2, 4, 7, 12), push=(1.0,), friction=(0.5, 0.725), shear=(0.0, 3.0)),
            *_grid("wall", rows=(1, 3, 7), columns=(4,), push=(1.0,), friction=(0.5, 1.1)),
            *_grid("arch", stones=(3, 9, 25), push=(0.1,), friction=(0.35, 1.1)),
        ],
        "joints": _grid("slider_crank", angle=(0.1, 1.6, 3.0, 4.6), clearance=(0.0,), friction=(0.2, 0.8, 1.4)),
        "unlike islands": _grid(
            "unlike_islands",
            velocity_ratio=(1e4, 1e6, 1e8),
            islands=(2, 4, 10),
            contacts=(3, 8),
            friction=(0.5, 3.0),
            seed=(0, 1),
        ),
        "steps and units": [
            Source(name, {**size, **unit}, repeats=1)
            for name, size in (("stack", {"blocks": 5, "push": 1.0}), ("pyramid", {"rows": 4, "push": 1.0, "friction": 0.725}))
            for unit in units
        ],
        "large graphs": [
            *_grid("local_graph", bodies=(30, 100, 400), seed=(0, 1)),
            *_grid("random", contacts=(60, 150), bodies=(30, 100), seed=(0, 1)),
        ],
        "recorded": _grid("recorded_step", case=[name for name in recorded_steps() if name not in SPATIAL_STEPS]),
    }


SPATIAL_STEPS = ("friction_1e3_a", "friction_1e3_b", "masses_1e6", "masses_1e8", "wall_4", "wall_8")


def _spatial() -> dict[str, list[Source]]:
    seeds = range(3)
    return {
        "unlike masses in space": [
            *_grid("cubes", boxes=(2, 5, 10), push=(1.0,), mass_ratio=(1e3, 1e6, 1e8)),
            *_grid("random_bodies", contacts=(6, 20, 40), mass_ratio=(1e4, 1e6, 1e8), seed=seeds),
            *_grid("sphere_pyramid", levels=(2, 3, 4), mass_ratio=(1e4, 1e6), seed=(0, 1)),
        ],
        "much friction in space": _grid("random_bodies", contacts=(4, 12, 40), friction=(10.0, 1e2, 1e4), seed=seeds),
        "hyperstatic in space": [
            *_grid("cubes", boxes=(1, 3, 10, 30), push=(1.0,), friction=(0.2, 0.8)),
            *_grid("sphere_pyramid", levels=(2, 3, 4, 5), friction=(0.3, 0.7, 1.0), noise=(0.03,)),
            *_grid("sphere_pyramid", levels=(5, 6), friction=(0.5, 1.0), noise=(0.0, 0.03), seed=(1,)),
        ],
        "large graphs in space": _grid("random_bodies", contacts=(100, 300), seed=seeds),
        "recorded in space": _grid("recorded_step", case=SPATIAL_STEPS),
    }


def vanishing_p(angle: float) -> float:
    """The coefficient of friction at which Painlevé's rod at this angle (rad) has p = 0: 1 + 3 cos^2 = 3 mu sin cos."""
    return float((1 + 3 * np.cos(angle) ** 2) / (3 * np.sin(angle) * np.cos(angle)))
