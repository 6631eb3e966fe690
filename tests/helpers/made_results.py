"""Results folders written from a few rows given by the test."""

from pathlib import Path
from typing import Any

from frictionbench.results.schema import SOLVES, TABLES
from frictionbench.results.store import new_shard, write_manifest, write_table

SETTINGS = {"suite": "made", "tolerances": [1e-4, 1e-8], "time_limit": 10.0}
MACHINE = {"host": "here", "processor": "some"}


def solve_row(variant: str, problem: str, tol: float = 1e-8, **given: Any) -> dict[str, Any]:
    """A solved cell of a ranked problem of eight unknowns in 3 ms, form .5, setup .5 and solve 2 ms, unless given."""
    row: dict[str, Any] = dict.fromkeys(column.name for column in SOLVES)
    row |= {"key": f"{variant}-{problem}-{tol:g}", "scene": "bar", "parameters": '{"friction": 0.2}', "solver": variant}
    row |= {"variant": variant, "model": "coulomb", "tol": tol, "time_limit": 10.0, "verdict": "solved", "host": "here"}
    row |= {"problem": problem, "step": 0, "phase": "step", "contacts": 2, "dimension": 2, "size": 8, "condition": 10.0}
    row |= {"trivial": False, "idle": False, "start": "cold", "status": "SOLVED", "claimed": True, "work": "{}"}
    row |= {"residual": tol / 10, "model_residual": tol / 10}
    row |= {"form_time": 5e-4, "setup_time": 5e-4, "solve_time": 2e-3} | given
    for step in ("form", "setup", "solve"):
        time = row[f"{step}_time"]
        row[f"{step}_times"] = given.get(f"{step}_times", None if time is None else [time] * 3)
    return row


def unanswered_row(variant: str, problem: str, verdict: str, tol: float = 1e-8, **given: Any) -> dict[str, Any]:
    """The row of a cell without an answer: timeout, crashed or skipped, with a reason."""
    nothing = dict.fromkeys(("status", "claimed", "residual", "model_residual", "work"))
    nothing |= dict.fromkeys(("form_time", "setup_time", "solve_time", "solve_times"))
    return solve_row(variant, problem, tol, **nothing | {"verdict": verdict, "reason": "for a reason"} | given)


def simulation_row(variant: str, **given: Any) -> dict[str, Any]:
    """A simulation of three steps that loses half of its energy."""
    row: dict[str, Any] = {"key": f"simulation-{variant}", "scene": "bar", "parameters": "{}", "time_limit": 10.0}
    row |= dict.fromkeys(("solver", "variant"), variant)
    row |= {"tol": 1e-8, "verdict": "solved", "host": "here", "scheme": "stepping", "energy_scale": 2.0, "energy_drift": -0.5}
    return row | {"times": [0.0, 0.1, 0.2], "energies": [2.0, 1.5, 1.0], "penetrations": [0.0] * 3} | given


def write_folder(
    folder: Path,
    solves: list[dict[str, Any]],
    simulations: list[dict[str, Any]] | None = None,
    batches: list[dict[str, Any]] | None = None,
    **manifest: Any,
) -> Path:
    """A finished run with these rows."""
    for table, rows in zip(TABLES, (solves, simulations or [], batches or []), strict=True):
        with new_shard(folder, table, "test") as write:
            for row in rows:
                write(row)
        write_table(folder, table, rows)
    write_manifest(folder, {"settings": SETTINGS, "machine": MACHINE, "finished": "now"} | manifest)
    return folder


def batch_row(variant: str, way: str, start: str = "cold", **given: Any) -> dict[str, Any]:
    """A hundred stacks of four contacts, solved at a thousand a second where single calls reach half of that, unless given."""
    row: dict[str, Any] = dict.fromkeys(column.name for column in TABLES["batches"])
    row |= {"key": f"batch-{variant}-{way}-{start}", "scene": "stack", "parameters": '{"blocks": 2}', "solver": variant}
    row |= {"variant": variant, "model": "lcp", "tol": 1e-8, "time_limit": 60.0}
    row |= {"verdict": "solved", "host": "here", "reason": ""}
    row |= {"way": way, "start": start, "dimension": 2, "contacts": 4, "problems": 100, "active": 1.0, "idle": 0.0}
    row |= {"verified": 1.0, "residual": 1e-12, "work": '{"pivots": 900}', "base": "lemke"}
    return row | {"times": [1e-3] * 3, "base_times": [2e-3] * 3} | given
