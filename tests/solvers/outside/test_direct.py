"""Adapters of outside libraries beside calls by hand: the same answers. `frictionbench fairness` measures the times."""

import numpy as np
import pytest

from frictionbench.harness.commands.charged import BLOCKS, TOL, charged_table
from frictionbench.harness.direct import CALLS, arrays
from frictionbench.problems import InputError, scene
from frictionbench.solvers import find, solve


@pytest.mark.parametrize("blocks", BLOCKS)
@pytest.mark.parametrize("spec", CALLS)
def test_a_call_by_hand_gives_the_adapters_answer(spec, blocks) -> None:
    info, _ = find(spec)
    if info.missing:
        pytest.skip(info.missing)
    problem = scene("stack", blocks=blocks, push=1.0).problem()
    by_hand, answer = CALLS[spec](arrays(problem), TOL), solve(problem, spec, tol=TOL)
    assert problem.velocity(by_hand) == pytest.approx(problem.velocity(answer.impulse), abs=1e-6)
    assert np.isfinite(by_hand).all()


def test_the_table_has_a_row_for_a_library_that_is_not_installed() -> None:
    table = charged_table(["quantecon"])
    assert table.row_count == 1
    with pytest.raises(InputError, match="solver: 'lemke' has no call by hand"):
        charged_table(["lemke"])
