"""The reader's own selection of problems ranks the solvers as the page does; the times of a motion's steps are drawn."""

import re

import pytest

from frictionbench.reports import page as selection
from frictionbench.reports.choice import choices
from frictionbench.reports.drawing.text import seconds
from frictionbench.reports.page import write_report
from frictionbench.reports.run import read_run
from tests.helpers.browser import browse, in_browser
from tests.helpers.made_results import solve_row, unanswered_row, write_folder


@pytest.fixture
def folder(tmp_path):
    """Two solvers on three problems of one scene and six of another; the second misses one, a third ran on one alone."""
    rows = [
        solve_row(name, f"{scene}{k}", scene=scene, contacts=2, solve_time=time * (k + 1), key=f"{name} {scene} {k}")
        for name, time in (("lemke", 2e-3), ("nsgs", 1e-3))
        for scene, count in (("bar", 3), ("rod", 6))
        for k in range(count)
    ]
    rows[-1] |= unanswered_row("nsgs", "rod5", "timeout", scene="rod", contacts=2, key="nsgs rod 5")
    return write_folder(tmp_path / "run", [*rows, solve_row("murty", "bar0", key="once")])


def test_cells_are_compact(folder, monkeypatch) -> None:
    data = selection.cells(read_run(folder))
    assert data["label"] == ["lemke", "murty", "nsgs"]
    assert len(data["cells"]) == 19
    assert len({cell[4] for cell in data["cells"]}) == 2  # strata
    assert data["cells"][0][7:] == [1e-8, 0.003, 0.0025, 10, 1e-9, 1]
    monkeypatch.setattr(selection, "MOST_CELLS", 10)
    assert selection.cells(read_run(folder)) == {}


@in_browser
def test_selection_has_the_means_of_the_page(folder) -> None:
    (kind,) = [kind for kind in choices(read_run(folder)) if kind.name == "in the plane"]
    page = browse(write_report(folder), "--dump-dom")
    (section,) = re.findall(r'<section class="filter" id="filter">(.*?)</section>', page, re.DOTALL)
    rows = [re.sub("<[^>]*>", " ", row).split() for row in re.findall(r"<tr[^>]*>(.*?)</tr>", section, re.DOTALL)[1:]]
    means = {place.label: seconds(place.mean, 3).split() for place in kind.choices[1e-8].places}
    assert [row[0] for row in rows] == [*means, "murty"]
    assert [row[2:4] for row in rows[:2]] == list(means.values())
    assert rows[0][1] == "9/9"
    assert rows[-1][1:3] == ["1/1", "–"]
