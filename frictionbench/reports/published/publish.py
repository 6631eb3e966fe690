"""Runs and summaries of runs as a static site and as text, each checked and none merged."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from frictionbench.reports.published.site import Entry, write_site
from frictionbench.reports.published.summary import summarise
from frictionbench.reports.run import read_run
from frictionbench.results import summaries
from frictionbench.results.files import ResultsError

Held = Callable[[Path, Iterable[str]], tuple[bool, str]]  # commands.stored_problems.held


def publish(given: Sequence[Path], site: Path | None, texts: Path | None, held: Held) -> Iterator[Path]:
    """Check the runs, write the site and the summaries, and yield what was written.

    given: results folders, summaries, or folders of summaries. held: checks the problems that a folder stores. Errors: of held,
    and ResultsError naming the folder or file and what is wrong with it; nothing is written then.
    """
    if site is None and texts is None:
        raise ResultsError("out: name a folder for the site with --out, or one for the summaries with --summaries")
    entries = [entry for path in given for entry in _entries(path, held)]
    names = [entry.summary["name"] for entry in entries]
    if twice := {name for name in names if names.count(name) > 1}:
        raise ResultsError(f"DIR: the run {min(twice)} is given twice")
    if texts is not None:
        for entry in entries:
            yield summaries.write(entry.summary, texts)
    if site is not None:
        yield write_site(entries, site)


def _entries(path: Path, held: Held) -> list[Entry]:
    if path.is_file():
        return [Entry(summaries.read(path))]
    if (path / "manifest.json").exists():
        run = read_run(path)
        return [Entry(summarise(run, held(path, run.rows["problem"])), path)]
    if found := sorted(path.glob("*.json")):
        return [Entry(summaries.read(one)) for one in found]
    raise ResultsError(f"{path}: neither a results folder nor a summary nor a folder of summaries")
