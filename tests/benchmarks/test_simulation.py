"""Time of a simulation's step outside the solver: contacts found, the problem made and checked, the state moved on."""

from itertools import cycle

import pytest

from frictionbench.problems.scenes import scene
from frictionbench.problems.schemes import SCHEMES, start
from frictionbench.solvers import find

SCENES = {
    "1 box": ("stack", {"blocks": 1}),
    "10 boxes": ("stack", {"blocks": 10, "push": 1.0}),
    "pyramid": ("pyramid", {}),
    "pendulum": ("pendulum", {}),
    "slider_crank": ("slider_crank", {}),
}


@pytest.mark.parametrize("scheme", ["anitescu_potra", "stewart_trinkle", "moreau"])
@pytest.mark.parametrize("name", SCENES)
def test_a_step(benchmark, name, scheme) -> None:
    known, settings = SCENES[name]
    made, advance, (_, method) = scene(known, **settings), SCHEMES[scheme], find("nsgs")
    if reason := advance.refuses(made):
        pytest.skip(reason)
    answers, now = [], start(made)

    def solve(problem):
        answers.append(method.solve(method.prepare(problem), 1e-6, 100).impulse)
        return answers[-1]

    advance(made, now, solve)
    replay = cycle(answers)
    step = benchmark(lambda: advance(made, now, lambda problem: next(replay)))
    benchmark.extra_info["contacts"] = len(step.contacts)
    assert step.time > now.time
