"""A comparison as Markdown, for a terminal and for a pull request: counts, the changes of each solver, and times.

Its template is templates/comparison.md.
"""

import os
import re
from functools import partial
from itertools import accumulate, takewhile

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from frictionbench.reports.drawing.text import code, escaped, residual, seconds
from frictionbench.results.cells import FILE_SEPARATOR
from frictionbench.results.changes import GONE, Flip
from frictionbench.results.commands import rerun
from frictionbench.results.compare import Comparison
from frictionbench.results.conventions import number
from frictionbench.results.times import ALPHA

LISTED = 20  # rows of a table; more are counted below it
LONGEST_COMMENT = 60_000  # characters; a comment on GitHub may have 65 536


def markdown(comparison: Comparison) -> str:
    """Return the comparison as Markdown. The template escapes untrusted text by `code` and `escaped`."""
    templates = PackageLoader("frictionbench.reports", "templates")
    made = Environment(loader=templates, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    made.filters |= {function.__name__: function for function in (code, escaped, seconds, number)}
    made.filters["residual"] = partial(residual, decimals=1)
    made.tests["finite"] = lambda value: bool(np.isfinite(value))
    changes = {
        variant: [change for change in comparison.changes if change.variant == variant and change.kind != "times"]
        for variant in solvers(comparison)
    }
    times = sorted(comparison.of("times"), key=lambda time: (not time.worse, not time.significant, -time.ratio))
    values = {"comparison": comparison, "changes": changes, "times": times, "listed": LISTED, "alpha": ALPHA}
    text = made.get_template("comparison.md").render(values, rerun_command=rerun_command, format_verdicts=format_verdicts)
    parts = re.split(r"\n{2,}", text.strip())
    whole = list(takewhile(lambda size: size < LONGEST_COMMENT, accumulate(len(part) + 2 for part in parts)))
    cut = [] if len(whole) == len(parts) else ["Truncated; `--out` writes the complete comparison as data."]
    return "\n\n".join([*parts[: len(whole)], *cut]) + "\n"


def summarise(comparison: Comparison) -> None:
    """Append the comparison to the summary of the step of a GitHub workflow, if the program runs in one."""
    if path := os.environ.get("GITHUB_STEP_SUMMARY"):
        with open(path, "a", encoding="utf-8") as summary:
            summary.write(markdown(comparison) + "\n")


def solvers(comparison: Comparison) -> list[str]:
    """Return the solvers with changes, those with a regression first."""
    worse = {change.variant for change in comparison.worse}
    return sorted({change.variant for change in comparison.changes}, key=lambda name: (name not in worse, name))


def rerun_command(comparison: Comparison, flip: Flip) -> str:
    """Return the command that runs the cell again, empty if it is gone."""
    if flip.after == GONE:
        return ""
    return rerun(comparison.current, flip.key.partition(FILE_SEPARATOR)[0], flip.variant, comparison.sources)


def format_verdicts(flip: Flip) -> str:
    return f"{flip.before} → {flip.after}"
