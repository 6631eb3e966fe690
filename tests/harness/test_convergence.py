"""Convergence histories: recorded outside the timed calls, verified at every point, for a few problems of a run."""

import numpy as np
import pytest

from frictionbench.harness import convergence
from frictionbench.harness.convergence import history
from frictionbench.harness.run import run
from frictionbench.problems.catalogue import scene
from frictionbench.problems.residual import residual
from frictionbench.reports.charts import convergence as chart
from frictionbench.reports.page import write_report
from frictionbench.reports.run import read_run
from frictionbench.results.files import ResultsError
from frictionbench.results.histories import CONVERGENCE, ConvergenceHistory, read_histories
from frictionbench.solvers import Answer, Status, find
from tests.helpers.runs import quiet, small_plan


@pytest.fixture(autouse=True)
def _large_budget(monkeypatch) -> None:
    """Raise the time budget of a history, which compilation in a first call may exceed on a busy machine."""
    monkeypatch.setattr(convergence, "HISTORY_BUDGET", 1e3)


def test_history_converges() -> None:
    problem = scene("stack", blocks=3).problem()
    _, solver = find("nsgs")
    units, residuals = history(problem, solver, 1e-8)
    assert units == sorted(set(units))
    assert residuals[-1] <= 1e-8 < residuals[0]
    assert residuals[0] == residual(problem, solver.solve(solver.prepare(problem), 1e-8, 1).impulse)


class FalseClaim:
    """Falsely reports SOLVED from the third unit of work on."""

    def prepare(self, problem):
        return problem.contacts

    def solve(self, prepared, tol, limit, start=None):
        return Answer(
            np.full((prepared, 2), 0.1), Status.SOLVED if limit >= 3 else Status.WORK_LIMIT, {}, history=(0.0,) * limit
        )


def test_history_uses_verified_residuals() -> None:
    problem = scene("stack", blocks=1).problem()
    units, residuals = history(problem, FalseClaim(), 1e-8)
    assert units == [1, 2, 3]
    assert residuals == [residual(problem, np.full((problem.contacts, 2), 0.1))] * 3
    assert residuals[0] > 1e-3


def test_run_writes_histories(tmp_path) -> None:
    folder = tmp_path / "run"
    run(small_plan(tolerances=(1e-8,)), folder, 1, quiet())
    found = read_histories(folder)
    solved = {(row.variant) for row in read_run(folder).rows.itertuples() if row.verdict == "solved"}
    assert found
    assert {history.variant for history in found} <= solved
    assert all(history.residuals[-1] <= 1e-8 for history in found)
    page = write_report(folder).read_text(encoding="utf-8")
    assert ("Residual against iterations" in page) == bool(chart.panels(read_run(folder)))


@pytest.mark.parametrize("text", ["{", "[1]", '[{"scene": "a"}]', "[[]]"])
def test_invalid_histories_are_refused(tmp_path, text) -> None:
    with pytest.raises(ValueError, match="the history of nsgs on bar is incomplete"):
        ConvergenceHistory("bar", "{}", 0, "nsgs", 2, [1], [])
    (tmp_path / CONVERGENCE).write_text(text, encoding="utf-8")
    with pytest.raises(ResultsError, match=r"convergence\.json: cannot be read"):
        read_histories(tmp_path)
