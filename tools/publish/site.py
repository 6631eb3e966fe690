"""A static site of published runs: a page for each suite and version with the runs of all machines, and an index with the
history over versions and machines, which a reader can sort and filter.

Runs are shown side by side and never merged: no number on the site is computed from two of them. Only listed files are copied
from a results folder, without following links. All text is escaped, and pages load nothing from elsewhere.
"""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from frictionbench.reports.accuracy import OVERALL
from frictionbench.reports.page import write_report
from frictionbench.reports.templates import environment
from frictionbench.results.conventions import RankBy
from frictionbench.results.files import replaced, subfolder, write_text
from frictionbench.results.schema import TABLES
from frictionbench.results.store import read_table
from tools.publish.summary import Summary, page_of, write

HERE = Path(__file__).parent
COPIED = ("manifest.json", "convergence.json", "maps/[!.]*.json", *(f"{table}.parquet" for table in TABLES))


class Entry(NamedTuple):
    """A published run: its summary, and the results folder that it was made from, if available."""

    summary: Summary
    folder: Path | None = None

    @property
    def page(self) -> str:
        """The name of the page of its suite and version."""
        return f"{page_of(self.summary['name'])}.html"


def write_site(entries: Sequence[Entry], site: Path, home: str = "") -> Path:
    """Write the site; return its index, which links to the address home, if given. Errors: ResultsError and OSError."""
    site.mkdir(parents=True, exist_ok=True)
    templates, downloads = environment(HERE), {entry.summary["name"]: _files(entry, site) for entry in entries}
    pages: dict[str, list[Entry]] = {}
    for entry in sorted(entries, key=lambda entry: (entry.summary["finished"], entry.summary["name"]), reverse=True):
        pages.setdefault(entry.page, []).append(entry)
    for page, runs in pages.items():
        values = {"runs": runs, "downloads": downloads, "same": [same_problems(run, runs) for run in runs], "by": tuple(RankBy)}
        write_text(site / page, templates.get_template("published_suite.html").render(values))
    rows = [row for runs in pages.values() for run in runs for row in history_rows(run)]
    write_text(site / "index.html", templates.get_template("published.html").render(pages=pages, rows=rows, home=home))
    return site / "index.html"


def history_rows(entry: Entry) -> list[dict[str, Any]]:
    """Return a row for each solver in the plane and in space, ranked from bodies, at the tightest target."""
    facts = {name: entry.summary[name] for name in ("suite", "version", "release", "finished", "machine")}
    rows = [row for row in entry.summary["rankings"] if row["kind"] in OVERALL.values() and row["by"] == RankBy.BODIES]
    finest = min((row["target"] for row in rows), default=None)
    return [facts | row | {"page": entry.page} for row in rows if row["target"] == finest]


def same_problems(entry: Entry, runs: Sequence[Entry]) -> list[str]:
    """Return sentences on how many problems of the run are equal, to the last bit, to those of each other run of the page."""
    own, others = entry.summary["problems"]["hashes"], [one.summary for one in runs if one is not entry]
    same = [sum(one["problems"]["hashes"].get(place) == found for place, found in own.items()) for one in others]
    told = zip(same, others, strict=True)
    return [f"{n} of {len(own)} problems are those of the run of {one['finished'][:16]}." for n, one in told]


def _csv(rows: pd.DataFrame) -> str:
    """Return the rows as CSV: arrays as JSON, and a quote before text that a spreadsheet would take for a formula."""
    plain = rows.map(lambda value: json.dumps(value.tolist()) if isinstance(value, np.ndarray) else value)
    return plain.replace("^(?=[=+@-])", "'", regex=True).to_csv(index=False)


def _files(entry: Entry, site: Path) -> list[dict[str, str]]:
    """Write the files of a run for download into its own folder. Return the address and a description of each."""
    name = entry.summary["name"]
    home = subfolder(site, name)
    write(entry.summary, home)
    write_text(home / "rankings.csv", _csv(pd.DataFrame(entry.summary["rankings"])))
    found = {"rankings.csv": "rankings, CSV", f"{name}.json": "summary, JSON"}
    if entry.folder is not None:
        for pattern in COPIED:
            for path in sorted(entry.folder.glob(pattern)):
                if path.is_file() and not path.is_symlink() and not path.parent.is_symlink():
                    place = subfolder(home, str(path.parent.relative_to(entry.folder)))
                    with replaced(place / path.name) as copy:  # does not write through an existing link
                        shutil.copyfile(path, copy)
        write_report(home)
        found = {"report.html": "the whole report", **found}
        for table in TABLES:
            rows = read_table(home, table)
            if len(rows):
                write_text(home / f"{table}.csv", _csv(rows))
                found |= {f"{table}.{kind}": f"{table}, {kind}" for kind in ("csv", "parquet")}
        found["manifest.json"] = "manifest: machine, versions, settings"
    return [{"address": f"{name}/{file}", "what": what} for file, what in found.items()]
