"""Time of a path search and of whole Newton solves, from 8 to 400 unknowns."""

import pytest

from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, find


@pytest.mark.parametrize("blocks", [1, 5, 10, 25, 50])
@pytest.mark.parametrize("spec", ["path_search", "path_search[crash=0]", "fischer_newton", "minmap_newton"])
def test_stack(benchmark, spec, blocks) -> None:
    _, solver = find(spec)
    prepared = solver.prepare(scene("stack", blocks=blocks, friction=0.2, push=0.05).problem())
    answer = benchmark(solver.solve, prepared, 1e-8, None)
    benchmark.extra_info.update(answer.work, n=8 * blocks, solved=answer.status is Status.SOLVED)
