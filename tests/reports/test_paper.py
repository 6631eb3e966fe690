"""Figures and tables for a paper: widths, captions, references, and reproducible bytes."""

import json
import re
import shutil
import subprocess

import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from frictionbench.harness.commands.options import parse_length, split_names
from frictionbench.reports.charts import pareto, profiles
from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.print import draw_panel, save_drawing
from frictionbench.reports.drawing.sheets import save_sheet
from frictionbench.reports.latex import Layout, booktabs, escaped, one_unit
from frictionbench.reports.paper import chosen, write_paper
from frictionbench.reports.references import cited, references
from frictionbench.reports.run import Run, read_run
from frictionbench.results.files import ResultsError
from frictionbench.solvers import available
from tests.helpers.made_results import simulation_row, solve_row, unanswered_row, write_folder
from tests.helpers.paths import ROOT

EVIL = "_\\input{/etc/passwd}$x^{%&#~|<é–µ\x00\u202e漢"
latex = pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")


@pytest.fixture
def run(tmp_path) -> Run:
    rows = [solve_row(name, p, tol) for name in ("lemke", "nsgs", "ccp[backend=osqp]") for p in "pqr" for tol in (1e-4, 1e-8)]
    rows += [unanswered_row("siconos[method=global_friction_3d_admm]", p, "timeout") for p in "pqr"]
    rows += [solve_row(EVIL, p, solve_time=2.0) for p in "pqr"]
    for row in rows:
        row["solver"] = row["variant"].partition("[")[0]
    return read_run(write_folder(tmp_path / "run", rows, [simulation_row("lemke")], machine={"processor": EVIL}))


def test_table_units_and_widths(run, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("frictionbench.reports.paper.CHARTS", ())
    paper = write_paper(tmp_path, run)
    times, verdicts = ((paper / f"{name}.tex").read_text() for name in ("times", "solvability"))
    assert r"solver & reached & mean, ms & reached & mean, ms & reached & mean, ms \\" in times
    assert r"lemke & 3/3 & 3.00 & 3/3 & 3.00 & 3/3 & 3.00 \\" in times
    assert r"\multicolumn{2}{c}{to 1e-4}" in times
    assert r"solver & cells & claimed & solved & timeout \\" in verdicts
    assert r"\cite{Lemke1965," in (paper / "solvers.tex").read_text()
    assert one_unit([2e-6, 3e-4, float("nan")]) == ("µs", ["2.00", "300", "–"])
    assert booktabs(["a", "b"], [["x" * 20, "y" * 20]], Layout()).wide is False
    assert booktabs(["a", "b"], [["x" * 60, "y" * 60]], Layout()).wide is True


def test_latex_escaping() -> None:
    assert escaped("a_b 100 %") == r"a\_b 100 \%"
    assert escaped("nsgs[x=1] 3 µs") == r"nsgs{[}x=1{]} 3 \textmu{}s"
    assert escaped("\\input{x} $^~") == r"\textbackslash{}input\{x\} \$\textasciicircum{}\textasciitilde{}"
    assert escaped("é漢\x00") == "e??"


def test_chosen_solvers(run) -> None:
    few = chosen(run, ["lemke", "ccp"])
    assert set(few.looks) == {"lemke", "ccp[backend=osqp]"}
    assert few.looks["lemke"][:3] == run.looks["lemke"][:3]
    assert set(few.summaries[1e-8]["label"]) == set(few.looks)
    with pytest.raises(ResultsError, match=r"solvers: murty is not in this run; there are .*lemke"):
        chosen(run, ["murty"])
    assert split_names("a, b[x=1,y=2],c") == ["a", "b[x=1,y=2]", "c"]


def test_widths_with_units() -> None:
    assert [parse_length(text) for text in ("85mm", "8.5cm", "3.35in", "3.35")] == pytest.approx(
        [85 / 25.4, 85 / 25.4, 3.35, 3.35]
    )
    for text in ("85", "wide", "3 ft", "..in"):
        with pytest.raises(Exception, match="is not a length"):
            parse_length(text)


def test_every_solver_has_its_references() -> None:  # but for the plug-ins that other tests load
    ours = [name for name, info in available().items() if info.ours]
    assert [name for name in ours if not cited(name)] == []
    named = {solver for entry in references() for solver in entry.solvers}
    assert named - set(available()) == {"all"}
    keys = [entry.key for entry in references()]
    assert len(keys) == len(set(keys)) == (ROOT / "reports/references.bib").read_text().count("\n@")


def test_bands_of_few_solvers(run, tmp_path) -> None:
    """Bands of many entries would hide each other."""
    few = chosen(run, ["lemke", "nsgs"])
    for drawn, banded in ((run, False), (few, True)):
        sheet, _ = save_sheet(profiles.CHART.panels(drawn), drawn.looks, tmp_path / "profiles")
        assert ("band-" in sheet.read_text()) is banded


def test_map_drawing(tmp_path) -> None:
    """Ground, tiles, dots and texts, each with its colour and at its place, as PDF, twice the same."""
    grid = tiles.Grid(("friction", "0", "1", 4), ("mass", "1", "9", 4), {"#112233": [(0, 0), (3, 3)]})
    wrong = [
        tiles.Tile(0, 0, 1, "#cc0000", "a reason"),
        tiles.Tile(1, 0, 1, "#cc0000", "another"),
        tiles.Tile(3, 3, 1, "#0000cc"),
    ]
    panels = (tiles.legend([("solved", "#a9d8b8", False)], grid), tiles.panel("lemke 90 %", wrong, grid, "#a9d8b8"))
    ax = Figure().subplots()
    draw_panel(ax, panels[1], 10.0, 20.0, 1.0)
    boxes = {to_hex(patch.get_facecolor()): patch.get_path().get_extents(patch.get_transform()) for patch in ax.patches}
    data = {colour: box.transformed(ax.transData.inverted()) for colour, box in boxes.items()}
    assert data.keys() == {"#a9d8b8", "#cc0000", "#0000cc"}
    left, right, low, high = 10 + tiles.LEFT, 10 + tiles.LEFT + tiles.ACROSS, 20 + tiles.TOP + tiles.UP, 20 + tiles.TOP
    assert data["#a9d8b8"].extents == pytest.approx([left, high, right, low])
    assert (data["#0000cc"].x1, data["#0000cc"].y0) == pytest.approx((right, high))
    assert (ax.lines[0].get_color(), len(ax.lines[0].get_xdata())) == ("#112233", 2)
    assert [text.get_text() for text in ax.texts] == ["lemke 90 %"]
    for name in "ab":
        save_drawing(tiles.Drawing("A map.", "map", panels), tmp_path / name, 7.0, "sans")
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()


@latex
def test_document_compiles(run, tmp_path, monkeypatch) -> None:
    """Figures as PGF in the document's own fonts, no table too wide, no reference undefined; twice the same bytes."""
    monkeypatch.setattr("frictionbench.reports.paper.CHARTS", (pareto.CHART, profiles.CHART))
    papers = [write_paper(tmp_path / name, run, Layout(3.2, "sans")) for name in ("a", "b") if not (tmp_path / name).mkdir()]
    first, second = ({file.name: file.read_bytes() for file in paper.iterdir()} for paper in papers)
    assert first == second
    assert {"pareto.pgf", "profiles.pgf"} <= first.keys()
    for command in ("pdflatex", "bibtex", "pdflatex", "pdflatex"):
        options = ["-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape"] if command == "pdflatex" else []
        done = subprocess.run([command, *options, "preview"], cwd=papers[0], capture_output=True, check=False, timeout=100)
        assert done.returncode == 0, done.stdout[-2000:]
    log = (papers[0] / "preview.log").read_text(encoding="latin-1")
    assert re.findall(r"Overfull.*|.*undefined.*", log) == []
    assert "root:" not in log + json.dumps({name: str(content) for name, content in first.items()})
