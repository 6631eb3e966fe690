"""Figures and tables for a paper: widths, captions, references, and reproducible bytes."""

import re
import shutil
import string
import subprocess

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from frictionbench.commands.options import parse_length, split_names
from frictionbench.reports.charts import speed_accuracy
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.files import save_sheet
from frictionbench.reports.drawing.style import looks, name_axes
from frictionbench.reports.latex import ESCAPED, cited, escaped, references
from frictionbench.reports.paper import booktabs, restricted, write_paper
from frictionbench.reports.printed import REFERENCES, Table, printed
from frictionbench.reports.run import Run, read_run
from frictionbench.reports.tables import setting
from frictionbench.solvers import available
from tests.helpers.command_line import frictionbench
from tests.helpers.made_results import simulation_row, solve_row, unanswered_row, write_folder
from tests.helpers.paths import ROOT

EVIL = "_\\input{/etc/passwd}$x^{%&#~|<é–µ\x00\u202e漢"
latex = pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")


@pytest.fixture
def run(tmp_path) -> Run:
    rows = [solve_row(name, p, tol) for name in ("lemke", "nsgs", "ccp[backend=osqp]") for p in "pqr" for tol in (1e-4, 1e-8)]
    siconos = "siconos[method=global_friction_3d_admm]"
    rows += [unanswered_row(siconos, p, "timeout", version="4.5.0") for p in "pqr"]
    rows += [solve_row(EVIL, p, solve_time=2.0) for p in "pqr"]
    for row in rows:
        row["solver"] = row["variant"].partition("[")[0]
    facts = {"machine": {"processor": EVIL}, "release": "1.0", "versions": {"frictionbench": "a}"}}
    facts["options"] = {"suite": "made", "scene": ["stack[blocks=5]"], "solver": ["lemke", "nsgs"], "time_limit": 2.0}
    return read_run(write_folder(tmp_path / "run", rows, [simulation_row("lemke")], **facts))


def test_table_units_and_widths(run, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("frictionbench.reports.paper.CHARTS", {})
    paper = write_paper(tmp_path, run)
    names = "times", "solvability", "solvers", "captions"
    times, verdicts, solvers, captions = ((paper / f"{name}.tex").read_text() for name in names)
    assert r"solver & " + " & ".join(rf"to \ensuremath{{10^{{-{k}}}}} & mean" for k in (4, 6, 8)) + r" \\" in times
    assert r"lemke & 3/3 & 3 ms & 3/3 & 3 ms & 3/3 & 3 ms \\" in times
    assert r"{@{}lrrrr@{}}" in verdicts
    assert r"solver & cells & claimed & solved & timeout \\" in verdicts
    assert r"{@{}lllr@{}}" in solvers
    assert r"\cite{CottlePangStone1992, Lemke1965, Murty1988} & -- \\" in solvers
    assert r"\cite{AcaryBremondHuber2018, Siconos} & 4.5.0 \\" in solvers
    assert r"Tolerances asked for: \ensuremath{10^{-4}}, \ensuremath{10^{-8}}; a time to" in captions
    assert captions.count("Suite made; run with scene stack{[}blocks=5{]}; solver lemke, nsgs; time limit 2.0; ") == 6
    assert "note = {frictionbench 1.0 revision a?}" in (paper / "references.bib").read_text()
    assert booktabs(Table("t", "", ["", REFERENCES], [["", ", ".join(["Lemke1965"] * 9)]])).startswith("% one column")
    for letters, first in ((20, "% one column"), (60, "% both columns")):
        assert booktabs(Table("t", "", ["a", "b"], [["x" * letters, "y" * letters]])).startswith(first)


def test_members_of_a_portfolio_are_named(tmp_path) -> None:
    made = read_run(write_folder(tmp_path, [solve_row("nsgs", "p"), solve_row("mixed", "p") | {"members": "quick, slow"}]))
    [caption] = [table.caption for table in printed(made) if table.name == "solvers"]
    assert caption.endswith("and references. mixed* is a portfolio, which may run quick, slow.")


def test_latex_escaping() -> None:
    assert escaped("a_b 100 %") == r"a\_b 100 \%"
    assert escaped("nsgs[x=1] 3 µs") == r"nsgs{[}x=1{]} 3 \ensuremath{\mu}s"
    assert escaped("\\input{x} $^~") == r"\textbackslash{}input\{x\} \ensuremath{\$}\textasciicircum{}\textasciitilde{}"
    assert escaped("é漢\x00") == "e??"
    assert re.fullmatch(ESCAPED, escaped(string.printable + "µμ–−×≤é 1e-8 3.2e-2"))
    assert escaped("1e-8 3e-2 x[tol=1e-8] 5e61a") == r"\ensuremath{10^{-8}} \ensuremath{3\cdot 10^{-2}} x{[}tol=1e-8{]} 5e61a"
    assert not any(re.fullmatch(ESCAPED, text) for text in (r"\input{x}", "{", "}", "$", r"\\", "%", "\n"))


def test_chosen_solvers(run) -> None:
    few = restricted(run, "solvers", ["lemke", "ccp"])
    assert set(few.looks) == {"lemke", "ccp[backend=osqp]"}
    assert few.looks["lemke"][:3] == run.looks["lemke"][:3]
    assert looks(["lemke", "interior_point*"])["lemke"] == looks(["lemke", "nsgs"])["lemke"]
    every = looks([*available(), *(f"nsgs[relaxation=1.{i}]" for i in range(30))]).values()
    assert len({look[:2] for look in every}) == len(every)
    for solver in ("osqp", "nsgs", "interior_point"):
        shown = looks([solver, f"{solver}[settings=tuned]", f"{solver}[settings=other]"]).values()
        greys = sorted(np.array(to_rgb(look.colour)) @ (0.299, 0.587, 0.114) for look in shown)
        assert np.diff(greys).min() > 0.05
    assert set(few.summaries[1e-8]["label"]) == set(few.looks)
    assert split_names("a, b[x=1,y=2],c, n < 100, d, n from 1000") == ["a", "b[x=1,y=2]", "c, n < 100", "d, n from 1000"]


def test_every_solver_has_its_references() -> None:  # but for the plug-ins that other tests load
    assert [name for name, info in available().items() if info.ours and not cited(name)] == []
    assert {solver for entry in references() for solver in entry.solvers} - set(available()) == {"all"}
    keys = [entry.key for entry in references()]
    assert len(keys) == len(set(keys)) == (ROOT / "reports/references.bib").read_text().count("\n@")


def test_figures_fit_the_page(run, tmp_path) -> None:
    rows = [solve_row("lemke", f"{scene}{k}", scene=f"scene_{scene}") for scene in range(20) for k in (0, 1)]
    many = read_run(write_folder(tmp_path / "many", rows))
    paper = write_paper(tmp_path, many, ["speed_accuracy"])
    assert sorted(path.name for path in paper.glob("*.pdf")) == [f"speed_accuracy{k}.pdf" for k in ("", "_2", "_3")]
    kept = re.findall(r".*bench\w+@speed_accuracy.*", (paper / "captions.tex").read_text())
    assert [re.findall(r"continued \((\d of \d)", line) for line in kept] == [[], [], ["2 of 3"], [], ["3 of 3"], []]
    few = restricted(many, "scenes", ["scene_3"])
    assert setting(few).startswith("Suite made; only scenes scene_3; frictionbench ")
    wide = (write_paper(tmp_path, few, ["profiles"], 7.0) / "captions.tex").read_text()  # of another setting, beside the first
    assert set(kept) < set(wide.splitlines())
    with (paper / "captions.tex").open("a") as file:  # of somebody else
        file.write("\\expandafter\\def\\csname benchcaption@x\\endcsname{\\input{x}}\n")
    assert (write_paper(tmp_path, few, ["profiles"], 7.0) / "captions.tex").read_text() == wide
    one = write_paper(tmp_path, few, ["speed_accuracy"])  # the other parts are gone, the other figure is kept
    assert sorted(path.name for path in one.glob("*.pdf")) == ["profiles.pdf", "speed_accuracy.pdf"]
    assert set(re.findall(r"@(profiles\w*|speed\w+)", (one / "captions.tex").read_text())) == {"profiles", "speed_accuracy"}
    refused = ("figures pie profiles", "figures map pareto", "scenes x scene_0", "solvers murty lemke")
    for option, name, there in map(str.split, refused):
        done = frictionbench("report", str(many.folder), "--paper", f"--{option}", name)  # refused before anything is made
        assert re.match(rf"frictionbench: {option}: .*{name}.*; there are .*{there}", done.stderr), done
    done = frictionbench("report", str(many.folder), "--paper", "--figures", "profiles")
    assert ((many.folder / "report.html").exists(), done.stderr) == (False, "figures: 1 done\n")


def widths(paper) -> list[float]:
    return [float(re.search(r'width="([\d.]+)pt"', file.read_text())[1]) for file in paper.glob("*.svg")]


def test_figures_have_the_width_that_was_asked_for(run, tmp_path) -> None:
    assert list(map(parse_length, ("85mm", "8.5cm", "3.35in", "3.35"))) == pytest.approx([85 / 25.4, 85 / 25.4, 3.35, 3.35])
    for text in ("85", "wide", "3 ft", "..in"):
        with pytest.raises(Exception, match="is not a length"):
            parse_length(text)
    paper = write_paper(tmp_path, run, ["profiles", "speed_accuracy", "energy"], 85 / 25.4)
    assert widths(paper) == pytest.approx([72 * 85 / 25.4] * max(3, len(widths(paper))), abs=0.5)
    few = read_run(write_folder(tmp_path / "few", [solve_row("lemke", scene, scene=scene) for scene in "abcdefghijklm"]))
    for shown in (few, restricted(few, "scenes", ["a", "b"])):  # of 13 panels, the last of which is alone in its part; of two
        assert {*widths(write_paper(tmp_path / "few", shown, ["speed_accuracy"], 6.4))} == {72 * 6.4}
    many = read_run(write_folder(tmp_path / "m", [solve_row(f"{k:040}", "p", t) for k in range(12) for t in (1e-4, 1e-8)]))
    text = (write_paper(tmp_path, many, ["profiles"], 80 / 25.4) / "profiles.svg").read_text()
    assert float(re.search(r'height="([\d.]+)pt"', text)[1]) <= 72 * 5.65  # the page has 7.6 inches, for the caption as well


@pytest.mark.parametrize(("width", "columns", "font"), [(3.35, 2, "serif"), (85 / 25.4, 1, "sans"), (7.0, 3, "sans")])
def test_titles_and_labels_lie_within_the_figure_and_apart(run, tmp_path, monkeypatch, width, columns, font) -> None:
    def measure(figure: plt.Figure, *_, **__) -> None:
        texts = [text for ax in figure.axes[:3] for text in (ax.title, ax.xaxis.label, ax.yaxis.label)]
        assert all(figure.bbox.count_contains(text.get_window_extent().get_points()) == 2 for text in texts)
        numbers = [text.get_window_extent() for text in (*figure.axes[0].texts, *figure.axes[0].get_xticklabels())]
        assert all(box.count_overlaps(numbers) <= 1 for box in numbers)

    monkeypatch.setattr(plt.Figure, "savefig", measure)
    [chart] = speed_accuracy.panels(run)
    labels = "factorisations over the fewest of any solver", "backward error of the answer"
    panels = [Panel("sphere_pyramid[levels=3,noise=0.3]: 45 contacts", lambda ax: chart.draw(ax) or name_axes(ax, *labels))] * 3
    save_sheet(panels, {}, tmp_path / "sheet", columns, (width / columns, 0.75 * width / columns), 7, font)


def compile_latex(folder, name, *commands) -> str:
    """The log of a document. Errors: AssertionError with the end of what a command prints, if it fails."""
    for command in commands:
        options = ["-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape"] if command == "pdflatex" else []
        done = subprocess.run([command, *options, name], cwd=folder, capture_output=True, check=False, timeout=100)
        assert done.returncode == 0, done.stdout[-2000:]
    return (folder / f"{name}.log").read_text(encoding="latin-1")


@latex
@pytest.mark.slow  # what docs/figures.md shows, in one column and two: a box wider than the column, a bitmap font
@pytest.mark.parametrize("options", ["", "twocolumn"])
def test_the_document_shown_compiles(run, tmp_path, options) -> None:
    page = (ROOT / "docs/figures.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```latex\n(.*?)```", page, re.DOTALL)
    width, *_ = re.findall(r"--paper.* --width (\d+mm)", page)
    paper = write_paper(tmp_path, run, ["profiles"], parse_length(width))
    preamble, _, body = shown.partition("\\begin{figure}")
    text = [rf"\documentclass[{options}]{{article}}", preamble, r"\begin{document}", r"\begin{figure}" + body]
    (paper / "shown.tex").write_text("\n".join([*text, r"\end{document}"]), encoding="utf-8")
    log = compile_latex(paper, "shown", "pdflatex", "bibtex", "pdflatex", "pdflatex")
    assert "Float too large" not in log
    assert [line for line in re.findall(r"Overfull \\hbox.*", log) if float(re.search(r"([\d.]+)pt", line)[1]) > 1] == []
    assert b"/Type3" not in (paper / "shown.pdf").read_bytes()
    mistyped = (paper / "shown.tex").read_text().replace(r"\benchcaption{profiles}", r"\benchcaption{profile}")
    (paper / "mistyped.tex").write_text(mistyped, encoding="utf-8")
    with pytest.raises(AssertionError):
        compile_latex(paper, "mistyped", "pdflatex")
    assert "frictionbench Error: captions.tex has no profile." in (paper / "mistyped.log").read_text(encoding="latin-1")


def test_the_figure_of_the_page(tmp_path, monkeypatch) -> None:
    """The script of docs/figures.md, with twelve solvers: its legend stands beside its axes, and within the figure."""
    rows = [solve_row(f"method_{i}[relaxation=1.{i}]", p, solve_time=10.0 ** (i - 6)) for i in range(12) for p in "pqr"]
    write_folder(tmp_path / "runs" / "standard", rows)
    monkeypatch.chdir(tmp_path)
    (script,) = re.findall(r"```python\n(.*?)```", (ROOT / "docs/figures.md").read_text(encoding="utf-8"), re.DOTALL)
    made: dict = {}
    exec(script, made)
    legend, figure = made["figure"].legends[0].get_window_extent(), made["figure"].bbox
    assert 0 <= legend.y0 <= legend.y1 <= made["ax"].get_tightbbox().y0
    assert 0 <= legend.x0 <= legend.x1 <= figure.x1
    plt.close("all")
