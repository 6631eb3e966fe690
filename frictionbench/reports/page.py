"""The report: one self-contained HTML file made from a results folder, and the files that it links to.

Names and reasons in a results folder may come from an untrusted source: the template escapes all text, the page loads nothing,
the only script that it runs is templates/page.js with filter.js, by its hash, and figures are drawn without interpreting names.
"""

from dataclasses import fields
from pathlib import Path

import pandas as pd

from frictionbench.reports.animation import write_animations
from frictionbench.reports.batches import has_batches, write_batches
from frictionbench.reports.run import Run, read_run
from frictionbench.reports.templates import environment, script
from frictionbench.reports.view import Page, view
from frictionbench.results.commands import Sources, rerun
from frictionbench.results.files import write_text


def write_report(folder: Path, run: Run | None = None) -> Path:
    """Write DIR/report.html, the animations in DIR/motion and the failed cells of maps in DIR/failures.txt; return the report.

    run: the result of read_run(folder), if at hand.
    Errors: results.files.ResultsError if DIR is not a results folder or a file in it cannot be read.
    """
    if has_batches(folder):
        return write_batches(folder)
    page = view(run or read_run(folder), write_animations(folder))
    if len(page.maps.failed):
        write_text(folder / "failures.txt", failures(folder, page.maps.failed, page.run.plugins))
    path = folder / "report.html"
    write_text(path, render(page))
    return path


def render(page: Page) -> str:
    """The page as HTML."""
    text, digest = script("page.js", "filter.js")
    values = {field.name: getattr(page, field.name) for field in fields(page)}
    return environment().get_template("page.html").render(values, script=text, script_hash=digest)


def failures(folder: Path, failed: pd.DataFrame, plugins: Sources) -> str:
    """A line for each failed cell: the command that runs it again, and what it is."""
    return "".join(
        f"{rerun(folder, row['key'], row['variant'], plugins)}"
        f"  # {row['label']}: {row['verdict']}, {row['scene']} {row['parameters']}, {row['contacts']:.0f} contacts\n"
        for row in failed.to_dict("records")
    )
