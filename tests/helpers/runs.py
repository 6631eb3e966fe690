"""Plans and run summaries shared by several tests."""

from dataclasses import replace
from pathlib import Path

from rich.console import Console

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.progress import Progress
from frictionbench.results import store


def quiet() -> Progress:
    return Progress(Console(quiet=True))


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


def verdicts(folder: Path) -> dict[str, tuple]:
    """Verdict, residual, work and energy drift of each row of a run, by key."""
    found = {}
    for table in ("solves", "simulations"):
        for row in store.read_table(folder, table).to_dict("records"):
            found[row["key"]] = (row["verdict"], row.get("residual"), row.get("work"), row.get("energy_drift"))
    return found
