"""Make docs/performance.md: the rates of a run of the suite `batch`, then the sections on steps of robots and large problems.

frictionbench run batch --out DIR
python -m tools.performance DIR > docs/performance.md
"""

import sys
from pathlib import Path
from textwrap import fill

from frictionbench.reports.batches import HEADER, METHOD, RateTable, rate_tables
from frictionbench.results.files import ResultsError
from frictionbench.results.store import read_table
from tools import large_problems

HEAD = """# Performance

## Many small problems

Made by `frictionbench run batch --out DIR`, and from that by `python -m tools.performance DIR`."""


def rates(folder: Path) -> str:
    """Return the first part of the page in Markdown. Errors: ResultsError if the folder holds no rows of batches."""
    rows = read_table(folder, "batches")
    if rows.empty:
        raise ResultsError(f"{folder}: has no rows of batches; `frictionbench run batch` writes some")
    tables = rate_tables(rows)
    return "\n\n".join([HEAD, *map(_wrapped, METHOD), *map(_table, tables)]) + "\n"


def _table(table: RateTable) -> str:
    marks = ["---"] * 3 + ["--:"] * (len(HEADER) - 3)
    lines = [f"| {' | '.join(row)} |" for row in [[*HEADER], marks, *table.rows]]
    return "\n\n".join([f"### {table.title}", _wrapped(table.description), "\n".join(lines)])


def _wrapped(text: str) -> str:
    return fill(text, 128, break_on_hyphens=False)


if __name__ == "__main__":
    from tools.robots import timing  # needs MuJoCo and its models

    sys.stdout.write("\n".join([rates(Path(sys.argv[1])), timing.section(), large_problems.section()]))
