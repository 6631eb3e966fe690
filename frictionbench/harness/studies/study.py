"""What a study is: a question, a method, and the tables that answer it.

A computed table is a function that needs no arguments and returns rows of plain values; its arguments make it smaller, for
tests. It runs in an isolated worker, as one unit: an interrupted study continues with the tables that are missing. Solver runs
are a plan like that of a suite, with the same isolation, verification and tables. What the tables say is written in
reports.studies, which reads nothing else.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from frictionbench.harness import machine
from frictionbench.harness.plans.plan import Plan
from frictionbench.results.store import Row
from frictionbench.results.studies import Description

COMPUTE = ("problems", "solvers", "harness", "results")  # the folders whose code computes tables
LIMIT = 900.0  # seconds for one table: several times what any takes


@dataclass(frozen=True)
class Table:
    """A computed table. rows: a function that gives its rows, and its name. columns: their meanings, with units."""

    rows: Callable[..., Iterable[Row]]
    columns: dict[str, str]

    @property
    def name(self) -> str:
        return self.rows.__name__


@dataclass(frozen=True)
class Study:
    """question, method: for readers. plan: solver runs, if any. recorded: those on recorded problems at given locations."""

    name: str
    question: str
    method: str
    tables: tuple[Table, ...] = ()
    plan: Callable[[], Plan] | None = None
    recorded: Callable[[Sequence[str]], Plan] | None = None

    @property
    def description(self) -> Description:
        columns = {table.name: table.columns for table in self.tables}
        words = {"question": self.question, "method": " ".join(self.method.split())}
        return Description(
            self.name,
            **words,
            columns=columns,
            runs=self.plan is not None,
            code=machine.revision(),
            content=machine.content(COMPUTE),
        )
