"""Plans and run summaries shared by several tests."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd
import psutil

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.results import store


def quiet() -> Progress:
    return Progress(quiet=True)


def small_plan(**changes) -> Plan:
    plan = Plan(
        suite="test",
        sources=(Source("stack", {"blocks": 2, "push": 1.0}), Source("random", {"seed": 1, "contacts": 4})),
        solvers=("lemke", "nsgs"),
        tolerances=(1e-4, 1e-8),
        simulations=(Source("stopping_block", {}, steps=5),),
        simulation_solvers=("lemke",),
        time_limit=5.0,
    )
    return replace(plan, **changes)


def run_of(folder: Path, *specs: str | Path, jobs: int = 1, **changes) -> pd.DataFrame:
    """The rows of a run of solvers, as the command line names them, on one problem at one tolerance."""
    variants, plugins = load_plugins([*map(str, specs)])
    one = {"sources": (Source("stack", {"blocks": 2}),), "simulations": (), "tolerances": (1e-6,)}
    run(small_plan(**one | {"solvers": variants, "plugins": plugins} | changes), folder, jobs, quiet())
    return store.read_table(folder, "solves")


def verdicts(folder: Path) -> dict[str, tuple]:
    """Verdict, residual, work and energy drift of each row of a run, by key."""
    found = {}
    for table in ("solves", "simulations"):
        for row in store.read_table(folder, table).to_dict("records"):
            found[row["key"]] = (row["verdict"], row.get("residual"), row.get("work"), row.get("energy_drift"))
    return found


MARK = "FRICTIONBENCH_TEST_MARK"


def marked(mark: str) -> list[psutil.Process]:
    """The running processes whose environment contains the mark, including detached ones."""
    found = []
    for process in psutil.process_iter():
        try:
            if process.environ().get(MARK) == mark and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
        except psutil.Error:
            continue
    return found


def soon(condition: Callable[[], bool], seconds: float = 60.0) -> bool:
    """Wait until it holds; whether it did within these seconds."""
    end = time.monotonic() + seconds
    while not (met := condition()) and time.monotonic() < end:
        time.sleep(0.005)
    return met
