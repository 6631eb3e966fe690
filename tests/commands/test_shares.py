"""The command that makes the table of what the members of hybrid bring, on two problems in place of all."""

import numpy as np
import pytest

from frictionbench.commands import shares
from frictionbench.harness.plans.named import problem_of
from frictionbench.harness.plans.plan import Source
from frictionbench.solvers.hybrid import PLANAR, SPATIAL
from frictionbench.solvers.portfolio.shares import BROUGHT

CHOSEN = {2: Source("stack", {"blocks": 2, "push": 1.0}), 3: Source("cubes", {"boxes": 2, "push": 1.0})}


def test_a_problem_is_brought_by_the_member_that_needs_the_least_limit_in_its_fraction() -> None:
    """The second is faster on two problems, and needs a smaller limit on the one that only it solves; none brings the last."""
    one = [1.0] * 8 + [2.0, np.inf, np.inf]
    other = [9.0] * 8 + [1.0, 1.0, np.inf]
    assert shares.brought(np.array([one, other, [np.inf] * 11])) == [9, 1, 0]
    assert shares.brought(np.array([one[:10], other[:10]])) == [9, 1]
    assert shares.brought(np.array([[np.inf], [np.inf]])) == [0, 0]


def test_the_table_names_all_members_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = {"lemke": [0.1, 9.0] * 2, "nsgs": [0.1, np.inf] * 2, "interior_point": [0.2, 3.0] * 2}
    monkeypatch.setattr(shares, "families", lambda dimension: {"few": [CHOSEN[dimension]] * 4})
    turns = iter([True, True, False, False] * 2)
    monkeypatch.setattr(shares, "simple_first", lambda problem: next(turns))
    monkeypatch.setattr(
        shares, "_seconds", lambda members, problems: np.array([seconds.get(name, [np.inf] * 4) for name in members])
    )
    made: dict[str, dict[tuple[int, str], dict[str, int]]] = {}
    exec(shares.table(), made)
    assert made["BROUGHT"].keys() == BROUGHT.keys()
    for (dimension, first), counts in made["BROUGHT"].items():
        assert list(counts) == list(BROUGHT[dimension, first])
        assert sorted(counts) == sorted(PLANAR if dimension == 2 else SPATIAL)
        assert sum(counts.values()) == 2


def test_what_is_not_solved_took_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shares, "ROUNDS", 1)
    (problem,) = (problem_of(source.scene, source.parameters) for source in [CHOSEN[2]])
    assert 0 < shares.time_of("lemke", problem) < 1
    assert shares.time_of("proximal_newton", problem) == np.inf  # it takes no planar contacts
    monkeypatch.setattr(shares, "TOL", 1e-300)
    monkeypatch.setattr(shares, "residual_with_floor", lambda problem, impulse: (1.0, 0.0))
    assert shares.time_of("lemke", problem) == np.inf
