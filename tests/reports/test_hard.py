"""The shares of problems solved, by what makes them hard."""

import pytest

from frictionbench.reports.run import read_run
from frictionbench.reports.tables import gaps, hard_shares
from tests.helpers.made_results import solve_row, unanswered_row, write_folder

HEAVY, LARGE = {"mass_ratio": 1e6}, {"contacts": 200}
ROWS = [
    solve_row("one", "a", **HEAVY),
    solve_row("one", "b", step=1, **HEAVY, **LARGE),
    solve_row("one", "c", step=2),
    solve_row("two", "a", verdict="wrong", residual=1.0, **HEAVY),
    solve_row("two", "b", step=1, **HEAVY, **LARGE),
    unanswered_row("two", "c", "timeout", step=2),
    unanswered_row("three", "a", "skipped", **HEAVY),
]


def test_shares_by_label(tmp_path) -> None:
    (found,) = hard_shares(read_run(write_folder(tmp_path, ROWS)))
    assert found.problems == {"all": 3, "masses": 2, "large": 1, "none of these": 1}
    table = found.table.set_index("label")
    assert list(table.index) == ["one", "two"]  # a solver that was skipped everywhere has no share
    assert table.loc["one"].to_list() == [1, 1, 1, 1]
    assert table.loc["two"].to_list() == pytest.approx([1 / 3, 1 / 2, 1, 0])


def test_plane_and_space_have_a_table_each(tmp_path) -> None:
    """Solvers of the plane alone leave no gap in space, nor does a start that only some problems have."""
    rows = [*ROWS, *(solve_row(name, "d", step=3, dimension=3, **HEAVY) for name in ("one", "four"))]
    run = read_run(write_folder(tmp_path, [*rows, solve_row("one", "b", key="warm", start="warm", step=1, **HEAVY, **LARGE)]))
    plane, space = hard_shares(run)
    assert [(one.where, one.problems["all"]) for one in (plane, space)] == [("in the plane", 3), ("in space", 1)]
    assert (set(space.table["label"]), gaps(run)) == ({"one", "four"}, 2)  # three has a row of one planar problem of three
