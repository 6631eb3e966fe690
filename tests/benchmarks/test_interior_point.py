"""Time of an interior point iteration and of its parts."""

import numpy as np
import pytest

from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.scenes import scene
from frictionbench.solvers import find
from frictionbench.solvers.interior.newton import new_work
from frictionbench.solvers.interior.point import start_point
from frictionbench.solvers.interior.predictor_corrector import nothing_yet, predictor_corrector
from frictionbench.solvers.interior.system import build_system, space_of
from frictionbench.solvers.sparse_lu.multifrontal import factorise
from tests.helpers.kernels import solve_factorised

PROBLEMS = {
    "stack of 50": scene("stack", blocks=50).problem(),
    "stack of 1000": scene("stack", blocks=1000).problem(),
    "pyramid of 15 rows": scene("pyramid", rows=15).problem(),
    "50 cubes": cubes(50),
    "1000 cubes": cubes(1000),
}


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("kernel", ["factorise", "solve"])
def test_factors(benchmark, kernel, name) -> None:
    system = build_system(PROBLEMS[name])
    work = new_work(system, np.inf)
    fill = np.random.default_rng(0).standard_normal(len(work.storage))
    factorise(system.fronts, fill, work.swap, 1e-3)
    solve_factorised(system.fronts, fill, work.swap, work.vector)
    benchmark.extra_info["variables"] = len(system.free_velocity)
    if kernel == "factorise":
        benchmark.pedantic(factorise, setup=lambda: ((system.fronts, fill.copy(), work.swap, 1e-3), {}), rounds=30)
    else:
        benchmark(solve_factorised, system.fronts, fill, work.swap, work.vector)


@pytest.mark.parametrize("name", PROBLEMS)
def test_ten_iterations(benchmark, name) -> None:
    system = build_system(PROBLEMS[name])
    space, work = space_of(system), new_work(system, np.inf)

    def iterate() -> int:
        best = nothing_yet(*system.offset.shape)
        return predictor_corrector(system, space, start_point(system, 1.0, 1.0), work, best, 0.0, 12, np.empty(11))

    assert iterate() == 11
    benchmark.extra_info["contacts"] = len(system.friction)
    benchmark(iterate)


@pytest.mark.parametrize("step", ["prepare", "solve"])
@pytest.mark.parametrize("spec", ["interior_point", "relaxation_ip"])
@pytest.mark.parametrize("name", ["stack of 50", "50 cubes"])
def test_a_whole_problem(benchmark, name, spec, step) -> None:
    problem, (_, method) = PROBLEMS[name], find(spec)
    prepared = method.prepare(problem)
    method.solve(prepared, 1e-8, None)
    if step == "prepare":
        benchmark(method.prepare, problem)
    else:
        benchmark(method.solve, prepared, 1e-8, None)
