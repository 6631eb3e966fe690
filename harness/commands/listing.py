"""The lists of `frictionbench list`."""

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from harness.plans.suites import SUITES
from problems import scenes
from problems.instances import instances
from solvers import available, find
from solvers.plugins import distribution, installed


def show(what: str) -> None:
    """Print the scenes, solvers or suites."""
    table = {"scenes": _scenes, "solvers": _solvers, "suites": _suites}[what]()
    console = Console()
    (console if console.is_terminal else Console(width=160)).print(table)


def _table(*columns: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in columns:
        table.add_column(column, overflow="fold")
    return table


def _scenes() -> Table:
    table = _table("scene", "parameters", "")
    listed: dict[str, Any] = {**scenes(), **instances()}
    for name, generator in listed.items():
        parameters = ", ".join(f"{key}={value}" for key, value in generator.parameters.items())
        table.add_row(name, parameters, generator.summary)
    return table


def _solvers() -> Table:
    table = _table("solver", "family", "model", "dimension", "version", "")
    for _, info in sorted(available().items()):
        for spec in info.specs:
            fact, _ = find(spec)
            version = f"not available: {fact.missing}" if fact.missing else fact.version
            table.add_row(Text(spec), fact.family, fact.model, ", ".join(map(str, fact.dimension)), version, info.summary)
    for name, point in installed().items():  # whose code is not run for a list
        table.add_row(name, "", "", "", distribution(point), f"from outside: {point.value}")
    return table


def _suites() -> Table:
    table = _table("suite", "sources", "solvers", "tolerances", "drives", "")
    for name, make in SUITES.items():
        plan = make()
        tolerances = ", ".join(f"{tol:g}" for tol in plan.tolerances)
        numbers = str(len(plan.sources)), str(len(plan.solvers)), tolerances, str(len(plan.drives))
        table.add_row(name, *numbers, (make.__doc__ or "").strip())
    return table
