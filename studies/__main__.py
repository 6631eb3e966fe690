"""Compute studies and write their page: `python -m studies all`, or the names of some."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from frictionbench import InputError
from frictionbench.results.files import ResultsError
from studies.running import NAMES, compute, study, write_page


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m studies", description="Compute studies and write their page.")
    parser.add_argument("names", nargs="+", choices=("all", *NAMES), metavar="NAME", help=f"all, or some of {', '.join(NAMES)}")
    parser.add_argument("--out", type=Path, default=Path("runs/studies"), metavar="DIR", help="folder of the studies")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="tables computed at the same time")
    given = parser.parse_args(arguments)
    names = [name for name in NAMES if study(name).runs()] if "all" in given.names else given.names
    lacking = {name: study(name).needs for name in NAMES if "all" in given.names and name not in names}
    if given.jobs < 1:
        parser.error("--jobs: must be at least 1")
    try:
        given.out.mkdir(parents=True, exist_ok=True)  # refused before anything is computed
        compute(names, given.out, given.jobs)
        print(write_page(given.out))
        if lacking:
            left = "; ".join(f"{name}, which needs {', '.join(needs)}" for name, needs in lacking.items())
            raise ResultsError(f"left out: {left}")
    except (InputError, ResultsError, OSError) as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
