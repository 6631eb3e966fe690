"""`compare --confirm`: the alerting cells once more, in fresh processes, the baseline's code and the current one in turn.

The baseline's code is a revision of the repository that one stands in, a checkout (of frictionbench, or of the repository that
the solver's file lies in), or an environment in which it is installed. Without it only the current code runs again: a verdict
or a count that was a passing one falls, and of times nothing can be said.
"""

import io
import json
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from frictionbench.harness import machine
from frictionbench.harness.commands.trusted import trusted
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems import InputError
from frictionbench.results import cells, store
from frictionbench.results.compare import Comparison, Limits, confirm, suspects
from frictionbench.results.store import ResultsError
from frictionbench.results.times import Pair
from frictionbench.solvers import plugins

PAIRS, PAIRS_UNTIMED = 8, 3
START = "import sys; sys.path.insert(0, sys.argv.pop(1)); from frictionbench.harness.cli import main; main()"


class Code(NamedTuple):
    """A state of the code: how to call it, and the solvers from outside as it has them."""

    command: list[str]
    solvers: list[str]


def confirmed(
    comparison: Comparison, limits: Limits, named: list[str], code: str | None, tell: Callable[[str], None]
) -> Comparison:
    """The comparison with those of its alerts that stand when their cells run again.

    named: solvers from outside, which the user trusts. code: where the baseline's code is. Errors: InputError naming the
    option, ResultsError where a run fails.
    """
    if comparison.unusable or comparison.benchmarks:
        return comparison
    settings = store.read_manifest(comparison.current)["settings"]
    slow = suspects(comparison, limits) if code and limits.times else []
    record, current = cells.read(comparison.baseline), cells.read(comparison.current)
    known = set(record.measured["variant"]) & set(current.measured["variant"])
    variants = {found.variant for found in (*comparison.worse, *slow)} & known
    if code and limits.times and not comparison.times:  # other machines' times say nothing: everybody's are taken
        variants = known
    if not variants:
        return comparison
    for variant in sorted(variants):
        trusted({"variant": variant}, settings, named)
    outside = [spec for spec in named if variants & comparison.sources.keys()]
    asked = [*_options(settings), *(part for variant in sorted(variants) for part in ("--solver", variant))]
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        now = Code([sys.executable, "-P", "-c", START, str(machine.PACKAGE.parent)], outside)
        before = baseline_code(code, outside, scratch) if code else None
        timed = before is not None and limits.times
        sides = [side for side in (before, now) if side is not None]
        pairs: list[Pair] = []
        for i in range(PAIRS if timed else PAIRS_UNTIMED):
            tell(f"confirm: pair {i + 1} of {PAIRS if timed else PAIRS_UNTIMED}")
            found = {id(side): _cells(side, asked, scratch / f"{i}-{sides.index(side)}") for side in sides[:: (-1) ** i]}
            base = found[id(before)] if before else record
            pairs.append((base.table, found[id(now)].table))
    return confirm(comparison, pairs, before is not None, limits)


def _options(settings: dict[str, Any]) -> list[str]:
    """The command line's of the run that has these settings. Errors: InputError where it took recorded problems."""
    try:
        suite, sources = settings["suite"], settings["sources"]
        if suite not in SUITES or any(source["file"] for source in sources):
            raise InputError(f"confirm: the problems of {suite} come from files, and its cells are not run again")
        own = {cells.spec(source.scene, json.dumps(source.parameters)) for source in SUITES[suite]().sources}
        met = [(source["scene"], cells.spec(source["scene"], json.dumps(source["parameters"]))) for source in sources]
        chosen = dict.fromkeys(scene if spec in own else spec for scene, spec in met)
        limits = ["--tol", ",".join(map(repr, settings["tolerances"])), "--time-limit", repr(settings["time_limit"])]
    except (KeyError, TypeError):
        raise ResultsError("confirm: the run's manifest does not say what was run") from None
    return [suite, *limits, *(part for scene in chosen for part in ("--scene", scene))]


def _cells(code: Code, asked: list[str], folder: Path) -> cells.Cells:
    """Run what is asked with a state of the code. Errors: ResultsError with its last words."""
    given = [part for spec in code.solvers for part in ("--solver", spec)]
    done = subprocess.run([*code.command, "run", *asked, *given, "--out", folder], capture_output=True, text=True, check=False)
    if done.returncode:
        words = (done.stderr.strip().splitlines() or ["no word"])[-1]
        raise ResultsError(f"confirm: {' '.join(code.command[:1])} ends with {done.returncode}: {words[:300]}")
    return cells.read(folder)


def baseline_code(code: str, named: list[str], scratch: Path) -> Code:
    """The baseline's code where `code` says; a revision is unpacked in scratch. Errors: InputError where it is not there."""
    folder = Path(code).absolute()
    if (folder / "bin" / "python").exists():
        return Code([str(folder / "bin" / "python"), "-P", "-m", "frictionbench"], named)
    top = _git("rev-parse", "--show-toplevel")
    home = Path(top.decode().strip()) if top else Path.cwd()
    if not folder.is_dir():
        folder = _unpacked(code, scratch / "code")
    if (folder / "frictionbench.py").is_file():
        raise InputError(f"code: {code} is from before the code was one package, frictionbench, and cannot be run")
    ours = (folder / "frictionbench" / "harness" / "cli.py").is_file()
    moved = [_moved(spec, home, folder) if not ours else spec for spec in named]
    return Code([sys.executable, "-P", "-c", START, str(folder if ours else machine.PACKAGE.parent)], moved)


def _moved(spec: str, home: Path, folder: Path) -> str:
    """The solver's file in another checkout of the repository at home."""
    if not plugins.is_file(spec):
        raise InputError(f"code: {spec} is installed; give an environment that has the baseline's, like .venv-base")
    path = Path(spec).absolute()
    if not path.is_relative_to(home) or not (folder / path.relative_to(home)).is_file():
        raise InputError(f"code: {spec} is not in {folder}")
    return str(folder / path.relative_to(home))


def _unpacked(revision: str, folder: Path) -> Path:
    archive = None if revision.startswith("-") else _git("archive", "--format=tar", revision)
    if archive is None:
        raise InputError(f"code: {revision!r} is neither a folder nor a revision of a git repository here")
    with tarfile.open(fileobj=io.BytesIO(archive)) as packed:
        packed.extractall(folder, filter="data")
    return folder


def _git(*arguments: str) -> bytes | None:
    try:
        return subprocess.run(["git", *arguments], capture_output=True, check=True, timeout=60).stdout
    except (OSError, subprocess.SubprocessError):
        return None
