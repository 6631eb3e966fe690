"""Adapters of outside libraries beside calls by hand: the same answers. `frictionbench fairness` measures the times."""

import numpy as np
import pytest

from frictionbench.harness.commands.charged import BLOCKS, TOL, charged_table
from frictionbench.harness.commands.claims import claims_table
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
    assert problem.velocity(by_hand.impulse) == pytest.approx(problem.velocity(answer.impulse), abs=1e-6)
    assert np.isfinite(by_hand.impulse).all()
    assert by_hand.clock is None or by_hand.clock > 0


def test_claims_are_compared_on_the_steps_of_a_scene() -> None:
    """OSQP's claims in closed loop hold, and the table has the numbers of both."""
    cells = [list(column.cells) for column in claims_table(["osqp", "quantecon"], ["stopping_block"]).columns]
    assert cells[0] == ["osqp\\[keep=false]", "quantecon\\[settings=default]"]
    assert int(cells[2][0]) > 20
    assert cells[3][0] == cells[2][0]
    assert cells[4][0] == "0"
    with pytest.raises(InputError, match="scene: unknown scene 'nowhere'"):
        claims_table(["osqp"], ["nowhere"])


def test_the_table_has_a_row_for_a_library_that_is_not_installed() -> None:
    table = charged_table(["quantecon"])
    assert table.row_count == 1
    with pytest.raises(InputError, match="solver: 'lemke' has no call by hand"):
        charged_table(["lemke"])
