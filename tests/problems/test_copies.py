"""Copies of problems are of the same kinds of arrays as the originals, so that no kernel is compiled again for them."""

import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.copies import duplicate, nudged
from frictionbench.problems.forms import delassus
from frictionbench.problems.instances.rod_chain import rod_chain
from frictionbench.problems.random_problem import random_problem


def _mechanical() -> FrictionProblem:
    return random_problem(3, contacts=4, bodies=2)


def _by_W() -> FrictionProblem:
    problem = _mechanical()
    return FrictionProblem.from_delassus(problem.W, problem.q, problem.friction, 2)


@pytest.mark.parametrize("make", [_mechanical, _by_W, lambda: rod_chain(links=3)], ids=["mechanical", "W", "joints"])
def test_no_kernel_is_compiled_for_a_copy(make) -> None:
    problem = make()
    kernels = delassus.delassus, delassus._blocks, delassus.measures, delassus.velocity, delassus.contact_velocity
    _use(problem)
    compiled = [len(kernel.signatures) for kernel in kernels]
    for same in (duplicate(problem), nudged(problem, 1), problem.balanced()[0], duplicate(problem.balanced()[0])):
        _use(same)
    assert [len(kernel.signatures) for kernel in kernels] == compiled


def _use(problem: FrictionProblem) -> None:
    """What methods ask of a problem."""
    problem.dense(), problem.csr(), problem.units
    problem.contact_velocity(0 * problem.offset)
