"""Time from a problem that is there to impulses, hybrid beside the methods it chooses from, in the plane and in space.

Its first member should be the fastest at every size: the table of docs/peers.md.
"""

import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.solvers import solve

BOXES = [1, 2, 3, 5, 10, 12, 16, 24, 50, 100, 300, 1000]
KINDS = {
    "stack": lambda nc: scene("stack", blocks=nc // 2, push=1.0).problem(),
    "sheared stack": lambda nc: scene("stack", blocks=nc // 2, shear=1.0).problem(),
    "pyramid": lambda nc: scene("pyramid", rows=round((nc / 2) ** 0.5)).problem(),
    "arch": lambda nc: scene("arch", stones=nc // 2 - 1, push=1.0).problem(),
    "discs": lambda nc: scene("disc_pile", rows=round((2 * nc / 3) ** 0.5)).problem(),
    "random": lambda nc: random_problem(nc, nc),
}
CUBES = [1, 2, 3, 5, 8, 12, 16, 25, 50, 100, 250]  # interfaces of four contacts


@pytest.mark.parametrize("boxes", BOXES)
@pytest.mark.parametrize("spec", ["hybrid", "nsgs", "lemke", "interior_point"])
def test_in_the_plane(benchmark, spec, boxes) -> None:
    run(benchmark, spec, scene("stack", blocks=boxes, push=1.0).problem())


@pytest.mark.parametrize("spec", ["hybrid", "lemke", "interior_point"])
@pytest.mark.parametrize("contacts", [24, 36, 48, 60, 80])
@pytest.mark.parametrize("kind", KINDS)
def test_where_pivots_are_no_longer_faster(benchmark, kind, contacts, spec) -> None:
    run(benchmark, spec, KINDS[kind](contacts))


@pytest.mark.parametrize("boxes", CUBES)
@pytest.mark.parametrize("spec", ["hybrid", "nsgs", "interior_point"])
def test_in_space(benchmark, spec, boxes) -> None:
    run(benchmark, spec, cubes(boxes, push=1.0))


def run(benchmark, spec, problem) -> None:
    limit = 1000 if spec == "nsgs" else None  # sweeps: beyond, it is no match
    answer = benchmark.pedantic(lambda: solve(problem.fresh(), spec, limit=limit), rounds=25, warmup_rounds=2)
    benchmark.extra_info.update(contacts=problem.contacts, solved=answer.status.name, **answer.work)
    assert answer.impulse.shape == (problem.contacts, problem.dimension)
