"""A solver with an injected fault is reported by the comparison on the right line."""

import pytest

from frictionbench.reports.comparison.markdown import markdown
from frictionbench.results import store
from frictionbench.results.compare import compare
from tests.helpers.command_line import frictionbench
from tests.helpers.made_results import write_folder

pytestmark = pytest.mark.slow  # a run of five solvers; the quick tests compare rows that were made by hand

SOLVER = '''
import numpy as np
from frictionbench.problems.forms.cone import project_cone
from frictionbench.problems.residual import residual
from frictionbench.solvers import Answer, Status, solver


@solver("jacobi", family="splitting", model="coulomb")
class Jacobi:
    """Projected Jacobi, with a fault where one is asked for."""

    fault: str = "none"

    def solve(self, problem, tol, limit, start=None):
        if self.fault == "crash" and problem.contacts == 2:
            raise ZeroDivisionError
        asked = 100 * tol if self.fault == "loose" else tol
        step = 0.45 if self.fault == "slow" else 0.5
        r, mu, count = np.zeros((problem.contacts, problem.dimension)), problem.friction, 0
        while residual(problem, r) > asked and count < 60:
            u = problem.contact_velocity(r)
            u[:, 0] += mu * np.linalg.norm(u[:, 1:], axis=1)
            r, count = project_cone(r - step * u / problem.scale[:, None], mu, problem.friction_bias), count + 1
        solved = residual(problem, r) <= asked or self.fault == "claim"
        return Answer(r, Status.SOLVED if solved else Status.WORK_LIMIT, {"iterations": count})
'''
FAULTS = ("none", "slow", "loose", "claim", "crash")


@pytest.fixture(scope="module")
def rows(tmp_path_factory) -> dict[str, list[store.Row]]:
    """The rows of each fault, as if they were of one solver."""
    home = tmp_path_factory.mktemp("worsened")
    (home / "jacobi.py").write_text(SOLVER, encoding="utf-8")
    named = [part for fault in FAULTS for part in ("--solver", f"jacobi[fault={fault}]")]
    given = ("--scene", "stack", "--scene", "stack[blocks=1]", "--solver", str(home / "jacobi.py"), *named)
    done = frictionbench("run", "smoke", *given, "--out", str(home / "run"))
    assert done.returncode == 0, done.stderr
    found: dict[str, list[store.Row]] = {fault: [] for fault in FAULTS}
    for row in store.rows(home / "run", "solves").values():
        fault = row["variant"].removeprefix("jacobi[fault=").removesuffix("]")
        if fault in found:
            place = f"{row['parameters']} {row['step']} {row['tol']:g}"
            found[fault].append(dict.fromkeys(("reason", "work")) | row | {"variant": "jacobi", "key": place})
    return found


@pytest.mark.parametrize(
    ("fault", "line"),
    [
        ("slow", "| **iterations** |"),
        ("loose", "| **solved → wrong** |"),
        ("claim", "| **unsolved → wrong** |"),
        ("crash", "| **solved → crashed** | `stack[blocks=1]` |"),
        ("none", "## worse 0"),
    ],
)
def test_worsened_solver_is_detected(rows, tmp_path, fault, line) -> None:
    result = compare(*(write_folder(tmp_path / name, rows[of]) for name, of in (("before", "none"), ("after", fault))))
    assert line in markdown(result)
    assert (result.exit_code, {found.variant for found in result.worse}) == ((1, {"jacobi"}) if fault != "none" else (0, set()))
