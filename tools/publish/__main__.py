"""The command `python -m tools.publish`: check runs, write their summaries and a site of them.

python -m tools.publish DIR... --out SITE            results folders, summaries, or folders of summaries
python -m tools.publish DIR... --summaries FOLDER    each run's summary as text
"""

import argparse
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from frictionbench.reports.run import read_run
from frictionbench.results.files import ResultsError
from tools.publish.site import Entry, write_site
from tools.publish.summary import read, summarise, write


def publish(given: Sequence[Path], site: Path | None, texts: Path | None) -> Iterator[Path]:
    """Check the runs, write the site and the summaries, and yield what was written.

    Errors: ResultsError and InputError naming the folder or file and what is wrong with it; then nothing is written.
    """
    entries = [entry for path in given for entry in _entries(path)]
    names = [entry.summary["name"] for entry in entries]
    if twice := {name for name in names if names.count(name) > 1}:
        raise ResultsError(f"DIR: the run {min(twice)} is given twice")
    if texts is not None:
        for entry in entries:
            yield write(entry.summary, texts)
    if site is not None:
        yield write_site(entries, site)


def _entries(path: Path) -> list[Entry]:
    if path.is_file():
        return [Entry(read(path))]
    if (path / "manifest.json").exists():
        return [Entry(summarise(read_run(path)), path)]
    if found := sorted(path.glob("[!.]*.json")):
        return [Entry(read(one)) for one in found]
    raise ResultsError(f"{path}: neither a results folder nor a summary nor a folder of summaries")


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.publish", description="Make a static site of results.")
    parser.add_argument("folders", metavar="DIR", nargs="+", type=Path, help="results folder, summary, or folder of summaries")
    parser.add_argument("--out", metavar="SITE", type=Path, help="the folder of the site")
    parser.add_argument("--summaries", metavar="FOLDER", type=Path, help="also write each run's summary as text")
    given = parser.parse_args()
    if not given.out and not given.summaries:
        parser.error("name a folder for the site with --out, or one for the summaries with --summaries")
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # no traceback
    try:
        for path in publish(given.folders, given.out, given.summaries):
            print(path)
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
