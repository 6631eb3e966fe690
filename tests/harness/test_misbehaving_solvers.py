"""All misbehaving solvers (tests/helpers/bad_solvers.py) in one run with two good ones: each costs its own cells alone.

Every planned row is there with the right verdict and reason, the good ones' verdicts, residuals and counters are those of a
run without the bad ones, no process of the run is left, and no cell takes more than its limit and what starting over costs.
"""

import subprocess
import sys
import time

import psutil
import pytest

from frictionbench.harness.plans.plan import Source
from frictionbench.harness.run import run
from frictionbench.harness.workers import pool
from frictionbench.harness.workers.plugins import load_plugins
from frictionbench.results import store
from tests.helpers.places import BAD_SOLVERS, ROOT
from tests.helpers.runs import quiet, small_plan, verdicts

GOOD = ("lemke", "nsgs")
LIMIT = 1.0
VERDICTS = {
    "segfault": ("crashed", "SIGSEGV"),
    "abort": ("crashed", "SIGABRT"),
    "kills_itself": ("crashed", "SIGKILL"),
    "exits": ("crashed", "exit code 0"),
    "hangs": ("timeout", "limit of 1 s"),
    "eats_memory": ("crashed", "MemoryError"),
    "compiles": ("unsolved", "no further progress"),
    "lies": ("wrong", "claimed solved within"),
    "not_a_number": ("wrong", "not finite"),
    "wrong_shape": ("wrong", "shape"),
    "no_answer": ("wrong", "returned None, not an Answer"),
    "changes_input": ("wrong", "changed its input"),
    "raises": ("crashed", "no idea"),
    "talks": ("wrong", "claimed solved within"),
    "gives_up": ("unsolved", "no further progress"),
    "blocks_signals": ("timeout", "limit of 1 s"),
    "replaces_alarm": ("timeout", "limit of 1 s"),
    "hangs_at_once": ("timeout", "limit of 1 s"),
    "hangs_later": ("timeout", "limit of 1 s"),
    "slow_impulse": ("timeout", "limit of 1 s"),
    "forks": ("wrong", "claimed solved within"),
    "leaves_a_child": ("wrong", "claimed solved within"),
    "leaves_a_thread": ("wrong", "claimed solved within"),
    "leaves_the_folder": ("wrong", "claimed solved within"),
    "sets_clocks": ("solved", ""),
    "spoils_others": ("wrong", "claimed solved within"),
    "scales_mass": ("wrong", "changed its input"),
    "remembers": ("unsolved", "it may reuse earlier results"),
    "answers_once": ("wrong", "the repeats disagree ("),
    "falls_silent": ("wrong", "returned None, not an Answer"),
    "complex_impulse": ("wrong", "impulse is an array of complex128"),
    "text_impulse": ("wrong", "impulse is an array of <U"),
    "masked_impulse": ("wrong", "impulse is a masked array"),
    "text_status": ("wrong", "status is of type str, not a Status"),
    "half_a_pivot": ("wrong", "work['pivots'] is of type float, not a whole number"),
    "counts_in_numpy": ("solved", ""),
    "talks_rubbish": ("solved", ""),
    "leaves_politely": ("crashed", "SystemExit: 3"),
    "shouts": ("crashed", "malformed reply"),
    "starts_programs": ("wrong", "claimed solved within"),
}
# Of a simulation of two steps, each of which is a problem met once.
SIMULATED = {
    **dict.fromkeys(("blocks_signals", "hangs_at_once"), "timeout"),
    "segfault": "crashed",
    **dict.fromkeys(("no_answer", "changes_input", "scales_mass", "leaves_a_child"), "wrong"),
    **dict.fromkeys(GOOD, "solved"),
}
MARK = "FRICTIONBENCH_TEST_MARK"


def plan_of(variants, plugins):
    scene = Source("stack", {"blocks": 2, "push": 1.0})
    return small_plan(
        sources=(scene,),
        solvers=variants,
        plugins=plugins,
        tolerances=(1e-8,),
        simulations=(Source("stack", {"blocks": 2, "push": 1.0}, steps=2),),
        simulation_solvers=[name for name in variants if name in SIMULATED],
        time_limit=LIMIT,
        simulation_limit=LIMIT,
        memory_limit=2**28,
    )


def marked(mark: str) -> list[psutil.Process]:
    """The processes, wherever they went, below one that was started with a mark in its environment."""
    found = []
    for process in psutil.process_iter():
        try:
            if process.environ().get(MARK) == mark and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
        except psutil.Error:
            continue
    return found


@pytest.fixture
def own_server(monkeypatch, tmp_path):
    """A server of this test's own, whose processes carry a mark."""
    monkeypatch.setenv(MARK, str(tmp_path))
    monkeypatch.setattr(pool, "_server", None)
    yield lambda: [process for process in marked(str(tmp_path)) if process.parent() != psutil.Process()]
    pool._server.close()
    assert marked(str(tmp_path)) == []


def test_all_that_misbehave_together_with_two_good_ones(own_server, tmp_path) -> None:
    variants, plugins = load_plugins([str(BAD_SOLVERS), *GOOD])
    assert set(variants) == VERDICTS.keys() | set(GOOD)
    begun = time.monotonic()
    run(plan_of(variants, plugins), tmp_path / "all", 2, quiet())
    taken = time.monotonic() - begun
    assert own_server() == []
    run(plan_of(GOOD, ()), tmp_path / "good", 2, quiet())
    alone, together = verdicts(tmp_path / "good"), verdicts(tmp_path / "all")
    assert {key: together[key] for key in alone} == alone
    rows = store.read_table(tmp_path / "all", "solves").set_index("solver")
    assert sorted(rows.index) == sorted(variants)
    assert rows.loc[list(VERDICTS), "verdict"].to_dict() == {name: verdict for name, (verdict, _) in VERDICTS.items()}
    reasons = rows["reason"].fillna("")
    told = {name: reason for name, (_, reason) in VERDICTS.items() if name != "remembers" or not rows.loc[name, "disturbed"]}
    assert {name: reasons[name] for name, reason in told.items() if reason not in reasons[name]} == {}
    assert (rows["time_limit"] == LIMIT).all()
    simulations = store.read_table(tmp_path / "all", "simulations").set_index("solver")
    assert simulations["verdict"].to_dict() == SIMULATED
    # A cell has its limit to be warmed up in, once to be solved and once to be repeated, and a second each to be ended.
    assert taken < (len(rows) + len(simulations)) * 3 * (LIMIT + 1)


FORKING = """
import os, sys
from frictionbench.harness.cells.timing import time_solver
from frictionbench.problems import LCP
from frictionbench.solvers import Answer, Status
from frictionbench.solvers.interface import with_all_steps

@with_all_steps
class Forks:
    def solve(self, lcp, tol, limit, start=None):
        os.fork()
        os.write(1, b".")
        return Answer(lcp.q, Status.SOLVED, z=lcp.q)

solver = Forks()
time_solver(solver, LCP([[1.0]], [1.0]), lambda prepared: solver.solve(prepared, 1e-8, None), lambda: None, most=5)
os.write(1, b"end")
"""


def test_children_that_a_solver_forks_do_not_double_on_repeats() -> None:
    """Each call is made by the worker alone: two processes a call come out of it, and one of them goes on."""
    done = subprocess.run([sys.executable, "-c", FORKING], capture_output=True, cwd=ROOT, check=True)
    assert done.stdout.count(b"end") == 1
    assert 2 * 3 <= done.stdout.count(b".") <= 2 * 8
