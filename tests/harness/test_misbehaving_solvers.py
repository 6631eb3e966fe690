"""A run of all misbehaving solvers (tests/helpers/bad_solvers.py) and two good ones: failures stay confined to their cells.

Every planned row is present with the right verdict and reason, the good solvers' verdicts, residuals and counters equal those
of a run without the bad ones, no process of the run is left, and no cell exceeds its limit by more than a restart takes.
"""

import time

import psutil
import pytest

from frictionbench.harness.plans.plan import Source
from frictionbench.harness.run import run
from frictionbench.harness.workers import pool
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.results import store
from tests.helpers.paths import BAD_SOLVERS
from tests.helpers.runs import MARK, marked, quiet, small_plan, verdicts

pytestmark = pytest.mark.slow  # the quick tests run no solver that hangs, exits or kills

GOOD = ("lemke", "nsgs")
LIMIT = 1.0
VERDICTS = {
    "segfault": ("crashed", "SIGSEGV"),
    "calls_os_exit": ("crashed", "exit code 0"),
    "exhausts_memory": ("crashed", "MemoryError"),
    "wrong_zero": ("wrong", "claimed solved within"),
    "nan_impulse": ("wrong", "not finite"),
    "modifies_friction": ("wrong", "changed its input"),
    "reports_stalled": ("unsolved", "no further progress"),
    "blocks_signals": ("timeout", "limit of 1 s"),
    "hangs_in_warm_up": ("timeout", "limit of 1 s"),
    "hangs_on_repeat": ("timeout", "limit of 1 s"),
    "slow_impulse": ("timeout", "limit of 1 s"),
    "forks": ("wrong", "claimed solved within"),
    "daemonises_child": ("wrong", "claimed solved within"),
    "freezes_clocks": ("solved", ""),
    "patches_lemke": ("wrong", "claimed solved within"),
    "modifies_mass": ("wrong", "changed its input"),
    "caches_result": ("unsolved", "it may reuse earlier results"),
    "zero_on_repeat": ("wrong", "the repeats disagree ("),
    "long_detail": ("solved", ""),
    "calls_sys_exit": ("crashed", "SystemExit: 3"),
    "writes_to_fds": ("crashed", "malformed reply"),
}
# Of a simulation of two steps, each of which is a problem met once.
SIMULATED = {
    **dict.fromkeys(("blocks_signals", "hangs_in_warm_up"), "timeout"),
    "segfault": "crashed",
    **dict.fromkeys(("modifies_friction", "modifies_mass", "daemonises_child"), "wrong"),
    **dict.fromkeys(GOOD, "solved"),
}


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


@pytest.fixture
def own_server(monkeypatch, tmp_path):
    """A worker server of this test alone, whose processes carry a mark in their environment."""
    monkeypatch.setenv(MARK, str(tmp_path))
    monkeypatch.setattr(pool, "_server", None)
    yield lambda: [process for process in marked(str(tmp_path)) if process.parent() != psutil.Process()]
    pool._server.close()
    assert marked(str(tmp_path)) == []


def test_failures_stay_confined_to_their_cells(own_server, tmp_path) -> None:
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
    expected = {
        name: reason for name, (_, reason) in VERDICTS.items() if name != "caches_result" or not rows.loc[name, "disturbed"]
    }
    assert {name: reasons[name] for name, reason in expected.items() if reason not in reasons[name]} == {}
    assert (rows["time_limit"] == LIMIT).all()
    simulations = store.read_table(tmp_path / "all", "simulations").set_index("solver")
    assert simulations["verdict"].to_dict() == SIMULATED
    # A cell has its limit to be warmed up in, once to be solved and once to be repeated, and a second each to be ended.
    assert taken < (len(rows) + len(simulations)) * 3 * (LIMIT + 1)
