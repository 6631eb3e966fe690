"""The report as Markdown, DIR/report.md: the sentences of the first screen, and all tables in print (reports.printed).

`make peers` writes it, and docs/peers.md contains an example.
"""

from pathlib import Path

from frictionbench.problems.verdicts import Verdict
from frictionbench.reports import choice, tables
from frictionbench.reports.drawing.text import code, escaped, pipe
from frictionbench.reports.printed import Table, printed
from frictionbench.reports.run import Run
from frictionbench.results.files import write_text


def write_markdown(folder: Path, run: Run) -> Path:
    """Write DIR/report.md; return its path."""
    path = folder / "report.md"
    parts = [*(f"{escaped(line)}\n" for line in _sentences(run)), *map(_table, printed(run)), _skipped(run)]
    write_text(path, "\n".join(filter(None, parts)).replace("<", "&lt;"))  # the report contains no HTML
    return path


def _sentences(run: Run) -> list[str]:
    ranked = {one.rank_by: choice.choices(one) for one in (run, run.ranked_by(run.rank_by.other))}
    headlines = choice.headline(ranked, run.outer_targets[-1])
    lines = [tables.setting(run), *headlines, tables.exclusions(run), choice.disturbed(run)]
    return [*filter(None, lines), *(f"**{what}**: {names}." for what, names in tables.sentences(run))]


def _table(table: Table) -> str:
    """A table below its name and caption."""
    body = "\n".join(pipe(table.header, (list(map(escaped, row)) for row in table.rows)))
    return f"## {table.name.replace('_', ' ').capitalize()}\n\n{escaped(table.caption)}\n\n{body}\n"


def _skipped(run: Run) -> str:
    """The solvers of libraries that are not installed."""
    reasons = tables.reasons(run)
    reasons = reasons[(reasons["verdict"] == Verdict.SKIPPED) & reasons["reason"].str.contains("not installed")]
    return "".join(f"Skipped: {code(row['label'])}, {escaped(row['reason'])}.  \n" for _, row in reasons.iterrows())
