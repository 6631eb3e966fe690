"""What an adapter is charged over a call by hand: form + setup + solve over the wall time of harness.direct.

The sample is a pushed stack of 2, 10 and 40 contacts at 1e-8. Each adapter and its call are timed in turn, one call after the
other, least of REPEATS: what else the machine does falls on both. Of a library in a child, setup and solve are its own clock
there, on both sides. Where the ratio is above FAIR, the docstring of the adapter's file says why, under Charged.
"""

from time import perf_counter
from typing import NamedTuple

from rich.markup import escape
from rich.table import Table

from frictionbench.commands.fairness import facts
from frictionbench.harness.direct import CALLS
from frictionbench.harness.direct.given import arrays
from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.check import require
from frictionbench.solvers import find

BLOCKS, TOL, REPEATS, FAIR = (1, 5, 20), 1e-8, 15, 1.3


class Charged(NamedTuple):
    """Seconds by hand and of the adapter, and of these by the library's own clock, if it has one; least of REPEATS each."""

    by_hand: float
    adapter: float
    clock: float | None

    def __str__(self) -> str:
        own = "none" if self.clock is None else f"{1e6 * self.clock:.0f}"
        return f"{1e6 * self.by_hand:.0f}, {1e6 * self.adapter:.0f}, {own}; {self.ratio:.2f}"

    @property
    def ratio(self) -> float:
        return self.adapter / self.by_hand


def charged_table(solvers: list[str]) -> Table:
    """A row for each library, or for those named; a library that is not installed has its reason. Errors: as of chosen."""
    heads = (f"{2 * n} contacts, µs: by hand, charged, own clock; ratio" for n in BLOCKS)
    table = Table("solver", *heads, f"why more than {FAIR}")
    for spec in chosen(solvers):
        info, _ = find(spec)
        if info.missing:
            table.add_row(escape(spec), info.missing)
            continue
        measured = [charged(spec, scene("stack", blocks=n, push=1.0).problem()) for n in BLOCKS]
        why = facts(info).get("Charged", "") if max(each.ratio for each in measured) > FAIR else ""
        table.add_row(escape(spec), *map(str, measured), escape(why))
    return table


def chosen(solvers: list[str]) -> list[str]:
    """The calls by hand of the named solvers, all if none is named. Errors: InputError where a named one has none."""
    known = {name for spec in CALLS for name in (spec, spec.partition("[")[0])}
    unknown = next((name for name in solvers if name not in known), None)
    require(unknown is None, "solver", f"{unknown!r} has no call by hand; there are {', '.join(CALLS)}")
    return [spec for spec in CALLS if not solvers or {spec, spec.partition("[")[0]} & set(solvers)]


def charged(spec: str, problem: FrictionProblem) -> Charged:
    """Time a call by hand and the adapter in turn."""
    _, solver = find(spec)
    given, by_hand, adapter, clock = arrays(problem), float("inf"), float("inf"), None
    for _ in range(REPEATS):
        begun = perf_counter()
        called = CALLS[spec](given, TOL)
        between, fresh = perf_counter(), problem.fresh()
        start = perf_counter()
        formed = solver.form(fresh)
        ready = perf_counter()
        answer = solver.solve(solver.setup(formed), TOL, None)
        solving = perf_counter() - ready if called.clock is None or answer.clock is None else answer.clock
        by_hand = min(by_hand, between - begun if called.clock is None else called.clock)
        adapter = min(adapter, ready - start + solving)
        if answer.clock is not None:
            clock = min(clock or float("inf"), answer.clock)
    return Charged(by_hand, adapter, clock)
