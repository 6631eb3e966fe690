"""What an adapter is charged over a call by hand: form + setup + solve over the wall time of harness.direct.

The sample is a pushed stack of 2, 10 and 40 contacts at 1e-8. Each adapter and its call are timed in turn, one call after the
other, least of REPEATS: what else the machine does falls on both. Of a library in a child, setup and solve are its own clock
there, on both sides.
"""

from time import perf_counter

from rich.markup import escape
from rich.table import Table

from frictionbench.harness.direct import CALLS, arrays
from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.check import require
from frictionbench.solvers import find

BLOCKS, TOL, REPEATS = (1, 5, 20), 1e-8, 15


def charged_table(solvers: list[str]) -> Table:
    """A row for each library, or for those named; a library that is not installed has its reason. Errors: as of chosen."""
    table = Table("solver", *(f"{2 * n} contacts: by hand, charged, ratio" for n in BLOCKS))
    for spec in chosen(solvers):
        missing = find(spec)[0].missing
        cells: list[str] = [missing] if missing else [_cell(spec, scene("stack", blocks=n, push=1.0).problem()) for n in BLOCKS]
        table.add_row(escape(spec), *cells)
    return table


def chosen(solvers: list[str]) -> list[str]:
    """The calls by hand of the named solvers, all if none is named. Errors: InputError where a named one has none."""
    known = {name for spec in CALLS for name in (spec, spec.partition("[")[0])}
    unknown = next((name for name in solvers if name not in known), None)
    require(unknown is None, "solver", f"{unknown!r} has no call by hand; there are {', '.join(CALLS)}")
    return [spec for spec in CALLS if not solvers or {spec, spec.partition("[")[0]} & set(solvers)]


def charged(spec: str, problem: FrictionProblem) -> tuple[float, float]:
    """Seconds by hand and of the adapter, least of REPEATS each."""
    _, solver = find(spec)
    given, by_hand, adapter = arrays(problem), float("inf"), float("inf")
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
    return by_hand, adapter


def _cell(spec: str, problem: FrictionProblem) -> str:
    by_hand, adapter = charged(spec, problem)
    return f"{1e6 * by_hand:.0f} µs, {1e6 * adapter:.0f} µs, {adapter / by_hand:.2f}"
