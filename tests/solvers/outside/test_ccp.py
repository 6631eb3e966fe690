"""The convex relaxation by outside libraries: they agree, solve it, and show its known errors."""

import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.solvers import Status, find, solve

ROUND = ["clarabel", *(["scs"] if find("scs")[0].missing is None else [])]
PLANAR = [*ROUND, "proxsuite", "osqp"]


@pytest.mark.parametrize("spec", PLANAR)
def test_failed_library_status(spec) -> None:
    answer = solve(scene("stack", blocks=8, push=0.3).problem(), spec, limit=1)
    assert answer.status is Status.FAILED
    assert answer.detail
    assert answer.impulse.shape == (16, 2)


def test_libraries_print_nothing(capfd) -> None:
    problem = scene("stack", blocks=3, push=0.3).problem()
    for spec in PLANAR:
        solve(problem, spec)
        solve(problem, spec, limit=1)
    assert capfd.readouterr().out == ""
