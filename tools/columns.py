"""Make the page on the tables' columns from their schema.

python -m tools.columns > docs/columns.md
"""

from typing import Any

from frictionbench.reports.drawing.text import pipe
from frictionbench.results.schema import SCHEMA_VERSION, TABLES

PAGE = """# Columns

Made from the schema by `python -m tools.columns`; a test compares the two. Schema version {version}; folders and
baselines of another version are refused.

A run writes up to three tables, `solves.parquet`, `simulations.parquet` and `batches.parquet`, which
`frictionbench.read_results(DIR)` reads as `pandas.DataFrame`. Units are SI, 1 marks a ratio. A number that was not measured is
null. Text columns named `parameters` and `work` hold JSON objects.

## solves

A row per cell: one problem, solver, start and tolerance; in the order of the run's plan, or by key while it has not finished.

{solves}

## simulations

A row per scene, scheme and solver, run in closed loop; in the same order.

{simulations}

## batches

A row per batch of small problems, solver, way to solve them all, start and tolerance; in the same order.

{batches}
"""


def describe() -> str:
    """Return all columns with types, units and meanings as a Markdown page."""
    return PAGE.format(version=SCHEMA_VERSION, **{name: _markdown(columns) for name, columns in TABLES.items()})


def _markdown(columns: tuple[Any, ...]) -> str:
    types = [f"list of {c.type.value_type}" if hasattr(c.type, "value_type") else str(c.type) for c in columns]
    cells = [[f"`{c.name}`", kind, c.unit, c.meaning.replace("|", "\\|")] for c, kind in zip(columns, types, strict=True)]
    return "\n".join(pipe(("column", "type", "unit", "meaning"), cells))


if __name__ == "__main__":
    print(describe(), end="")
