"""Time of what comes before a solve: a checked problem, its forms and a solver's setup, on stacks of 1 to 24 boxes."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.scenes import scene
from frictionbench.solvers import find, solve

BOXES = [1, 5, 10, 24]
FIELDS = ("mass", "normal", "tangent", "friction", "free_velocity", "bias")


@pytest.mark.parametrize("boxes", BOXES)
def test_a_checked_problem(benchmark, boxes) -> None:
    problem = scene("stack", blocks=boxes, push=1.0).problem()
    given = {name: getattr(problem, name) for name in FIELDS}
    assert benchmark(lambda: FrictionProblem(**given)).hash == problem.hash


@pytest.mark.parametrize("boxes", BOXES)
@pytest.mark.parametrize("spec", ["nsgs", "lemke", "path_search", "interior_point", "relaxation_ip", "hybrid", "clarabel"])
def test_form_and_setup(benchmark, spec, boxes) -> None:
    problem, (_, method) = scene("stack", blocks=boxes, push=1.0).problem(), find(spec)
    prepared = benchmark(lambda: method.prepare(problem.fresh()))
    assert method.solve(prepared, 1e-8, None).impulse.shape == (problem.contacts, 2)


@pytest.mark.parametrize("boxes", BOXES)
@pytest.mark.parametrize("spec", ["lemke", "interior_point", "hybrid"])
def test_from_a_problem_to_impulses(benchmark, spec, boxes) -> None:
    problem = scene("stack", blocks=boxes, push=1.0).problem()
    answer = benchmark(lambda: solve(problem.fresh(), spec))
    assert np.isfinite(answer.impulse).all()
