"""The notebooks of the documentation run, and show what their text says."""

import sys

import matplotlib.pyplot as plt
import pytest

from tests.helpers.paths import ROOT

NOTEBOOKS = ROOT / "docs" / "notebooks"


def executed(name: str, folder, monkeypatch) -> list[str]:
    """What each cell of a notebook prints."""
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import cells

    names: dict[str, object] = {}
    plt.switch_backend("Agg")
    printed = [
        cells.run_cell(code, names, str(folder)) for code in cells.code_cells((NOTEBOOKS / f"{name}.md").read_text("utf-8"))
    ]
    sys.modules.pop("cells")
    return printed


def test_choose(tmp_path, monkeypatch) -> None:
    size, first, heavy = executed("choose", tmp_path, monkeypatch)
    assert size == "10 contacts, 15 velocities"
    assert [line.split()[1] for line in first.splitlines()] == ["solved", "solved", "relaxed"]
    assert heavy.startswith("lemke      solved")


def test_debug(tmp_path, monkeypatch) -> None:
    claimed, velocities, corrected = executed("debug", tmp_path, monkeypatch)
    assert claimed.startswith("SOLVED")
    assert "wrong" in claimed
    assert velocities.count("contact") == 6
    assert "SOLVED" in corrected
    assert " solved " in corrected


def test_figure(tmp_path, monkeypatch) -> None:
    executed("figure", tmp_path, monkeypatch)
    (ax,) = plt.gcf().axes
    reached = [line.get_ydata()[-1] for line in ax.lines]
    assert len(reached) == 3
    assert reached[0] < reached[-1]
    plt.close("all")
