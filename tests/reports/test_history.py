"""Runs over time as charts: changes are marked, and times of another machine are not drawn."""

from dataclasses import replace

import matplotlib as mpl
from matplotlib.figure import Figure

from frictionbench.reports.comparison.history import changes, draw, lines, write_history
from tests.helpers.made_results import solve_row, write_folder


def test_changes_are_marked(tmp_path) -> None:
    folders = []
    for k, (sweeps, verdict) in enumerate([(10, "solved"), (10, "solved"), (14, "solved"), (14, "unsolved")]):
        rows = [solve_row("<nsgs>", "p", work=f'{{"sweeps": {sweeps}}}'), solve_row("<nsgs>", "q", verdict=verdict)]
        folders.append(write_folder(tmp_path / f"run{k}", rows, finished=f"2026-0{k + 1}-01"))
    found = lines(folders)
    assert changes(found["<nsgs>"]) == {2: "sweeps 10 → 14", 3: "2 → 1 cells solved"}
    page = write_history(found, tmp_path / "history.html").read_text(encoding="utf-8")
    assert "sweeps 10 → 14" in page
    assert "<nsgs>" not in page
    assert "&lt;nsgs&gt;" in page


def test_a_solver_without_common_answers_has_a_sentence(tmp_path) -> None:
    """In place of a panel without lines."""
    rows = [
        [solve_row("a", "p", verdict=verdict), solve_row("b", "p", work='{"pivots": 3}')] for verdict in ("solved", "wrong")
    ]
    folders = [write_folder(tmp_path / str(k), own, finished=f"2026-01-0{k + 1}") for k, own in enumerate(rows)]
    page = write_history(lines(folders), tmp_path / "history.html").read_text(encoding="utf-8")
    assert page.count("<figure>") == 1
    assert "a has nothing to draw" in page
    assert "1 → 0 cells solved" in page


def test_times_of_another_machine_are_left_out(tmp_path) -> None:
    folders = [
        write_folder(tmp_path / str(k), [solve_row("a", "p", work='{"pivots": 3}')], finished=f"2026-01-0{k + 1}")
        for k in range(3)
    ]
    own = lines(folders)["a"]
    elsewhere = [own[0]._replace(run=replace(own[0].run, machine={"host": "there"})), *own[1:]]
    with mpl.rc_context():
        ax = Figure().subplots()
        draw(ax, elsewhere)
    drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
    assert list(drawn["pivots"]) == [1, 1, 1]
    assert list(drawn["time"][1:]) == [1, 1]
    assert drawn["time"][0] != drawn["time"][0]
