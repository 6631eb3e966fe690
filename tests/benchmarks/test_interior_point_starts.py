"""The starts and limits of interior_point: what each of them is worth, to tune them anew.

The sets are problems on which the predictor-corrector is often trapped: a hundred random ones each of 20 to 119 contacts with
large friction coefficients or masses unlike by 1e4, piles of discs, and pyramids of spheres, which alone need the starts around
the relaxation's solution. `solved`, `factorisations` and `by others` (the nested solvers' own) are the sums over a set; a
change is an improvement where more are solved, or as many with fewer factorisations. The constants of
solvers.interior.central_path and solvers.interior.fischer_burmeister are compiled into the kernels: edit them and compare the
rows "as it is".

All variants take about five minutes on one core. Pyramids of ten levels need minutes each and are not among the sets; their
figures are in docs/tried.md. As measured, semismooth Newton saves two fifths of the factorisations where friction is large in
the plane, and half the PATIENCE a sixth of those in space.
"""

from functools import cache

import pytest

from frictionbench.problems.instances.random_bodies import random_bodies
from frictionbench.problems.instances.spheres import sphere_pyramid
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import interior_point, solve

PLANE = {
    "friction 20": lambda seed: random_problem(seed, contacts=20 + seed, friction=20.0),
    "masses": lambda seed: random_problem(seed, contacts=20 + seed, friction=5.0, mass_ratio=1e4),
    "discs": lambda seed: scene("disc_pile", rows=6 + seed, friction=0.5).problem(),
}
SPACE = {
    "friction 20": lambda seed: random_bodies(seed, contacts=20 + seed, friction=20.0),
    "masses": lambda seed: random_bodies(seed, contacts=20 + seed, friction=1.5, mass_ratio=1e4),
    "spheres": lambda seed: sphere_pyramid(seed, levels=5),
}
COUNT = {"spheres": 6, "discs": 13}  # a hundred of the others


def without_one(name: str) -> dict[str, dict[str, object]]:
    starts = getattr(interior_point, name)
    return {f"{name} without {start}": {name: starts[:i] + starts[i + 1 :]} for i, start in enumerate(starts)}


def halved_and_doubled(*names: str) -> dict[str, dict[str, object]]:
    return {
        f"{name} x {by}": {name: type(v)(v * by)} for name in names for v in [getattr(interior_point, name)] for by in (0.5, 2)
    }


PLANE_VARIANTS = {
    "as it is": {},
    **without_one("NEWTON_STARTS"),
    "no semismooth Newton": {"NEWTON_SHARE": 0},
    **without_one("PLANAR_STARTS"),
    **halved_and_doubled("NEWTON_SHARE", "SHARE", "PATIENCE", "SWEEPS", "PATH_DISTANCE"),
}
SPACE_VARIANTS = {
    "as it is": {},
    **without_one("RELAXED_STARTS"),
    "first start twice as fast": {"FIRST_START": (1.0, 20.0, 10.0)},
    "first start not widened": {"FIRST_START": (1.0, 10.0, 1.0)},
    "never close": {"CLOSE": 0.0},
    "no polishing": {"POLISHING": 1},
    **halved_and_doubled("SHARE", "PATIENCE", "PATH", "SHORT_PATH"),
}


@cache
def problems(dimension: int, name: str):
    make = (PLANE if dimension == 2 else SPACE)[name]
    return [make(seed) for seed in range(COUNT.get(name, 100))]


@pytest.mark.parametrize("variant", PLANE_VARIANTS)
@pytest.mark.parametrize("name", PLANE)
def test_in_the_plane(benchmark, monkeypatch, name, variant) -> None:
    sweep(benchmark, monkeypatch, problems(2, name), PLANE_VARIANTS[variant])


@pytest.mark.parametrize("variant", SPACE_VARIANTS)
@pytest.mark.parametrize("name", SPACE)
def test_in_space(benchmark, monkeypatch, name, variant) -> None:
    sweep(benchmark, monkeypatch, problems(3, name), SPACE_VARIANTS[variant])


def sweep(benchmark, monkeypatch, given, constants) -> None:
    for constant, value in constants.items():
        monkeypatch.setattr(interior_point, constant, value)
    answers = benchmark.pedantic(lambda: [solve(problem, "interior_point") for problem in given], rounds=1)
    benchmark.extra_info["solved"] = sum(
        residual(problem, answer.impulse) <= 1e-8 for problem, answer in zip(given, answers, strict=True)
    )
    benchmark.extra_info["factorisations"] = sum(answer.work["factorisations"] for answer in answers)
    nested = [count for answer in answers for unit, count in answer.work.items() if unit.endswith(" factorisations")]
    benchmark.extra_info["by others"] = sum(nested)
