"""The public names of `import frictionbench as fb` are complete, documented and quick to import, and their examples run."""

import ast
import doctest
import inspect
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import frictionbench as fb
from frictionbench import files, plot, tables, verification
from frictionbench.results.files import ResultsError
from frictionbench.results.schema import TABLES
from frictionbench.solvers import interface
from tests.helpers.made_results import simulation_row, solve_row, write_folder
from tests.helpers.paths import ROOT

CALLED = [name for name in fb.__all__ if name not in ("plot", "__version__")]
NO_ERRORS = ("scenes", "instances", "available", "Answer", "Status", "residual_floor", "InputError", "Verdict")


@pytest.fixture
def run(tmp_path, monkeypatch) -> Path:
    """A folder to work in, with a results folder `run`."""
    monkeypatch.chdir(tmp_path)
    rows = [solve_row(solver, "p") for solver in ("lemke", "nsgs")]
    return write_folder(tmp_path / "run", rows, [simulation_row("lemke")])


def test_public_names_are_listed_and_typed() -> None:
    assert dir(fb) == sorted(fb.__all__)
    imported = {
        alias.asname or alias.name
        for node in ast.walk(ast.parse((ROOT / "frictionbench" / "__init__.py").read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and re.fullmatch(r"frictionbench(?!\.lazy).*", str(node.module))
        for alias in node.names
    }
    assert imported | {"__version__"} == set(fb.__all__)
    assert all(getattr(fb, name) is not None for name in fb.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = fb.nothing


def test_import_loads_no_library() -> None:
    code = "import sys, frictionbench; print([name for name in ('numpy', 'numba', 'pandas') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("name", CALLED)
def test_public_names_have_examples(name, run) -> None:
    text = inspect.getdoc(getattr(fb, name)) or ""
    assert ">>> " in text, f"the docstring of {name} has no example"
    if callable(getattr(fb, name)) and name not in NO_ERRORS:
        assert "Errors: " in text, f"the docstring of {name} does not say which errors it raises"
    assert_examples_run(getattr(fb, name), name)


@pytest.mark.parametrize("module", [fb, files, plot, tables, verification], ids=lambda module: module.__name__)
def test_public_examples_run(module, run) -> None:
    assert_examples_run(module, module.__name__)


@pytest.mark.parametrize("chart", plot.__all__)
def test_every_plot_is_documented_with_an_example(chart, run) -> None:
    text = inspect.getdoc(getattr(plot, chart)) or ""
    assert all(word in text for word in (">>> ", "results: ", "Errors: "))
    assert_examples_run(getattr(plot, chart), chart)


def assert_examples_run(what, name: str) -> None:
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    example = doctest.DocTestParser().get_doctest(
        inspect.getdoc(what) or "", vars(plot) | {name: what, "fb": fb} | vars(fb), name, None, None
    )
    printed: list[str] = []
    before = dict(interface._solvers)
    try:
        runner.run(example, out=printed.append)
    finally:
        interface._solvers.clear()  # an example may list a solver
        interface._solvers.update(before)
    assert not printed, "".join(printed)


def test_save_and_load(tmp_path) -> None:
    problem, lcp = fb.scene("stack", blocks=2).problem(), fb.LCP(np.eye(2), [-1.0, 1.0])
    for what, name in ((problem, "a.npz"), (problem, "a.hdf5"), (lcp, "b.npz")):
        fb.save(what, tmp_path / name)
        assert fb.load(str(tmp_path / name)).hash == what.hash
    for what, name in ((problem, "a.txt"), (lcp, "b.h5")):
        with pytest.raises(fb.InputError):
            fb.save(what, tmp_path / name)
    with pytest.raises(fb.InputError, match="no such file"):
        fb.load(tmp_path / "nowhere.npz")


def test_verify_answer() -> None:
    problem = fb.scene("stack", blocks=2, push=1.0).problem()
    answer = fb.solve(problem, "lemke")
    good = fb.verify(problem, answer, 1e-8)
    assert (good.verdict, good.reason) == (fb.Verdict.SOLVED, "")
    assert good.residual == fb.residual(problem, answer.impulse)
    assert good.floor == fb.residual_floor(problem, answer.impulse)
    bad = fb.verify(problem, fb.Answer(0.9 * answer.impulse, fb.Status.SOLVED), 1e-8)
    assert (bad.verdict, bad.reason[:21]) == (fb.Verdict.WRONG, "claimed solved within")
    assert repr(bad).startswith("Finding(wrong, residual ")
    assert fb.verify(problem, fb.solve(problem, solver="apgd"), 1e-4).model_residual <= 1e-4
    assert fb.verify(problem.lcp(), fb.solve(problem.lcp(), "lemke"), 1e-8).verdict == fb.Verdict.SOLVED
    with pytest.raises(fb.InputError, match="tol"):
        fb.verify(problem, answer, 0.0)


@pytest.mark.parametrize(
    ("given", "field"),
    [
        (np.zeros((8, 2)), "an Answer, got .*residual takes impulses"),
        (fb.Answer(np.zeros((8, 2)), "SOLVED"), "status"),
        (fb.Answer({}, fb.Status.SOLVED), "impulse"),
        (fb.Answer(np.zeros((8, 2)), fb.Status.SOLVED, softness="x"), "softness"),
        (fb.Answer(np.zeros((8, 2)), fb.Status.SOLVED, work={"steps": 0.5}), "work"),
    ],
)
def test_verify_names_the_field_of_a_malformed_answer(given, field) -> None:
    problem = fb.scene("stack", blocks=4).problem()
    for what in (problem, problem.lcp()):
        with pytest.raises(fb.InputError, match=f"answer: .*{field}"):
            fb.verify(what, given, 1e-8)


@pytest.mark.parametrize("given", [None, 3, "stack", np.eye(2), fb.scene("stack")])
def test_what_is_no_problem_is_refused(given, tmp_path) -> None:
    with pytest.raises(fb.InputError, match="problem: must be.*" + r"its method problem\(\)" * hasattr(given, "problem")):
        fb.verify(given, fb.Answer(np.zeros((1, 2)), fb.Status.SOLVED), 1e-8)
    with pytest.raises(fb.InputError, match="problem: must be"):
        fb.save(given, tmp_path / "a.npz")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: fb.scene(None), "scene"),
        (lambda: fb.instance(5), "instance"),
        (lambda: fb.residual(None, np.zeros((1, 2))), "problem"),
        (lambda: fb.residual(fb.LCP(np.eye(2), [-1.0, 1.0]), np.zeros(2)), "problem"),
        (lambda: fb.residual(fb.scene("stack").problem(), None), "impulse"),
        (lambda: fb.residual_floor(fb.scene("stack").problem(), "none"), "impulse"),
        (lambda: fb.load(None), "path"),
        (lambda: fb.load_step(5), "path"),
        (lambda: fb.save(fb.scene("stack").problem(), None), "path"),
        (lambda: fb.read_results(None), "folder"),
        (lambda: plot.profiles(5), "folder"),
    ],
)
def test_arguments_of_another_type_are_named(call, field) -> None:
    with pytest.raises(fb.InputError, match=f"^{field}: "):
        call()


def test_results_are_tables_with_their_columns_documented(run) -> None:
    results = fb.read_results(str(run))
    assert list(results.solves.columns) == [column.name for column in TABLES["solves"]]
    assert set(results.simulations["verdict"]) == {"solved"}
    assert results.manifest["settings"]["suite"] == "made"
    for other, told in (("nowhere", "folder$"), (run.name[:2], rf"folder \(did you mean {re.escape(str(run))}\?\)$")):
        with pytest.raises(ResultsError, match=f"no such results {told}"):
            fb.read_results(run.with_name(other))


def test_plots_draw_on_the_axes_given(run) -> None:
    results, ax = fb.read_results(run), Figure().subplots()
    assert fb.plot.profiles(results, ax=ax, panel=-1) is ax
    assert len(ax.get_lines()) == 2
    assert {text.get_text() for text in ax.get_legend().get_texts()} == {"lemke", "nsgs"}
    assert fb.plot.speed_accuracy(results, ax=Figure().subplots(), panel="bar").get_title() == "bar"
    with pytest.raises(ValueError, match="has no panel 'nothing'"):
        fb.plot.profiles(results, ax=ax, panel="nothing")
    with pytest.raises(ValueError, match="nothing to draw"):
        fb.plot.growth(results, ax=ax)
