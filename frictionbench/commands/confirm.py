"""`compare --confirm`: run the cells with alerts again in new processes, alternating the baseline's code and the current code.

The baseline's code is a revision of the repository in the current folder, a checkout, or an environment where it is installed.
Without it only the current code runs again: alerts that do not recur are dropped, and times are not compared.
"""

import io
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from frictionbench.commands.stored_cell import trusted
from frictionbench.harness import machine, process
from frictionbench.harness.dependencies import unquoted
from frictionbench.harness.plans.suites import SUITES
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.harness.workers.pool import scratch_folder
from frictionbench.problems import InputError
from frictionbench.problems.check import require
from frictionbench.problems.compiled import PACKAGE
from frictionbench.problems.verdicts import ACCEPTED, Verdict
from frictionbench.results import cells, store
from frictionbench.results.compare import Comparison, Limits, confirm, other_loads
from frictionbench.results.conventions import RankBy
from frictionbench.results.files import ResultsError
from frictionbench.results.times import Pair, may_be_slower
from frictionbench.solvers import executable, plugins

PAIRS, PAIRS_UNTIMED = 8, 3  # runs of each code: eight equal signs are significant at 1 %; verdicts and counters hardly vary
FEW_LOST = 0.1  # share of the solved cells: rounding on another machine changes fewer verdicts
ENVIRONMENT = Path(sys.prefix).resolve()  # may be inside a repository, but belongs to none of its versions
GIVE_BASELINE = "give a checkout or an environment that holds the baseline's"
DIFFERS = "{} was made with another content of {}; run it again in a new folder"
START = "import runpy, sys; sys.path.insert(0, sys.argv.pop(1)); runpy.run_module('frictionbench', run_name='__main__')"


class Code(NamedTuple):
    """A version of the code: the command that runs it, and its copies of the outside solvers."""

    command: list[str]
    solvers: list[str]


def confirmed(
    comparison: Comparison, limits: Limits, named: list[str], code: str | None, tell: Callable[[str], None]
) -> Comparison:
    """Run cells again and return the comparison with only the alerts that recur.

    named: outside solvers that the user trusts. code: the location of the baseline's code. tell: prints a line of progress.
    Errors: InputError naming the option, ResultsError if a run fails.
    """
    if comparison.unusable:
        return comparison
    if code is not None:
        require_code(code)
    manifest = store.read_manifest(comparison.current)
    settings = manifest["settings"]
    stored, current = cells.read(comparison.baseline), cells.read(comparison.current)
    require(current.code in ("", machine.revision()), "DIR", DIFFERS.format(current.path, f"frictionbench, {current.code}"))
    known = set(stored.measured["variant"]) & set(current.measured["variant"])
    variants = known if code else {change.variant for change in comparison.worse} & known
    made = {variant: plugin.get("content") for plugin in settings.get("plugins") or () for variant in plugin["solvers"]}
    loaded = load_plugins(named)[1]
    unloaded = sorted(variants.difference(*(plugin.solvers for plugin in loaded)))
    for plugin in chain(loaded, *(trusted({"variant": variant}, settings, named) for variant in unloaded)):
        for variant in plugin.solvers:
            require(made.get(variant) in (None, plugin.content), "DIR", DIFFERS.format(current.path, plugin.source))
    if not variants:
        return comparison
    trusted_specs = named if variants & comparison.sources.keys() else []
    outside = [plugins.absolute(spec) if plugins.defines_all(spec) else spec for spec in trusted_specs]
    with scratch_folder() as scratch:
        now = Code([sys.executable, "-P", "-c", START, str(PACKAGE.parent)], outside)
        before = baseline_code(code, outside, scratch) if code else None
        if before and before.command == now.command:  # only its plug-ins may differ
            variants &= comparison.sources.keys()
            require(bool(variants), "code", f"{code} holds no frictionbench, of which all these solvers are; {GIVE_BASELINE}")
        options = [*run_options(manifest), *(part for variant in sorted(variants) for part in ("--solver", variant))]
        timed = before is not None and limits.times
        most = PAIRS if timed else PAIRS_UNTIMED
        own = [[Path(each.source).parent] if plugins.is_file(each.source) else plugins.places(each.source) for each in loaded]
        tested = [_home(), *(place.resolve() for place in chain(*own))]
        pairs: list[Pair] = []
        others, untimed = dict[str, list[str]](), ""
        for *base, ran in _alternating([before, now] if before else [now], options, scratch, limits.rank_by, most, tell):
            for other in chain(*other_loads(current, ran, alone=False).values()):
                raise InputError(f"DIR: {DIFFERS.format(current.path, f'{other}, or it cannot be read')}")
            pairs.append(((base or [stored])[0].table, ran.table))
            for again in base:
                others |= other_loads(stored, again)
                untimed = untimed or of_another_version(stored, again, ran, tested)
            if timed and PAIRS_UNTIMED <= len(pairs) < most and not may_be_slower(pairs, most, limits.slowdown):
                tell(f"confirm: ended after {len(pairs)} of {most} pairs: whatever the others show, no solver is found slower")
                break
    if before:
        require_whole(f"code: {code}", stored.table, [table for table, _ in pairs])
    result = confirm(comparison, pairs, before is not None, limits, others)
    return replace(result, unusable=f"code: {untimed}") if untimed and timed and not result.worse else result


def _alternating(
    codes: list[Code], options: list[str], scratch: Path, rank_by: RankBy, most: int, tell: Callable[[str], None]
) -> Iterator[list[cells.Cells]]:
    """Run with each code in turn, in the opposite order every second time; yield the cells in the order of `codes`."""
    begun = time.monotonic()
    for i in range(most):
        left = f", about {(time.monotonic() - begun) / i * (most - i) / 60:.1f} min left" if i else ""
        tell(f"confirm: {i} of {most} pairs of runs are done{left}")
        way = (-1) ** i
        yield [_cells(code, options, Path(tempfile.mkdtemp(dir=scratch)), rank_by) for code in codes[::way]][::way]


def require_whole(code: str, stored: pd.DataFrame, runs: list[pd.DataFrame]) -> None:
    """Check that the baseline's code works here, since one that lacks something would excuse any failure. Errors: ResultsError
    if a cell that the baseline solved never runs, or if all, or more than one and FEW_LOST, of these are not solved."""
    for variant, solved in stored[stored["verdict"].isin(ACCEPTED)].groupby("variant"):
        lost = 0
        for key, cell in solved.iterrows():
            again = [ran.loc[key] for ran in runs if key in ran.index]
            verdicts = {row["verdict"] for row in again}
            if again and verdicts <= {Verdict.CRASHED, Verdict.SKIPPED}:
                message = f"{again[0]['verdict']} here and solved in the baseline: {again[0]['reason']}"
                raise ResultsError(f"{code}: {variant}, {cell['scene']} ({key}) is {message}")
            lost += bool(again) and not verdicts & {*ACCEPTED, Verdict.TIMEOUT}
        if lost == len(solved) or lost > max(1, FEW_LOST * len(solved)):
            message = f"of {len(solved)} cells of {variant} that the baseline solved {lost} are not solved here"
            raise ResultsError(f"{code}: {message}, as if it lacked something; {GIVE_BASELINE}")


def of_another_version(stored: cells.Cells, before: cells.Cells, after: cells.Cells, tested: list[Path]) -> str:
    """Return why a plug-in's times with the baseline's code are not the baseline's, so that a slower solver could pass, or "".

    tested: files and folders of the version under test. The environment is of it only where one of them is in there.
    """
    for variant, names in other_loads(stored, before).items():
        known, then = (side.loaded.get(variant, {}) for side in (stored, before))
        for name in names:
            place = before.places.get(variant, {}).get(name, "")
            path = Path(unquoted(place))
            around = [one for one in tested if path.resolve().is_relative_to(one)]
            is_tested = any(one.is_relative_to(ENVIRONMENT) or not path.resolve().is_relative_to(ENVIRONMENT) for one in around)
            if name not in then:
                return f"{variant} loads no {name} there, as for the baseline; {GIVE_BASELINE}"
            is_new = path.is_absolute() and is_tested if name != executable.COMMAND else not path.is_absolute()
            if name in known and place in after.places.get(variant, {}).values() and is_new:
                return f"both versions run the current {name}, not the baseline's; {GIVE_BASELINE}, or --no-times"
    return ""


def run_options(manifest: dict[str, Any]) -> list[str]:
    """Return the command-line options of a run, except for its solvers. Errors: InputError if its problems come from files."""
    settings, given = manifest["settings"], manifest.get("options", {})
    try:
        suite = settings["suite"]
        if suite not in SUITES or any(source["file"] for source in settings["sources"]):
            raise InputError(f"confirm: the problems of {suite} come from files; its cells cannot be run again")
        limits = ["--tol", ",".join(map(repr, settings["tolerances"])), "--time-limit", repr(settings["time_limit"])]
        return [suite, *limits, *(part for scene in given.get("scene") or () for part in ("--scene", scene))]
    except (KeyError, TypeError, AttributeError):
        raise ResultsError("confirm: the run's manifest lacks the settings to run its cells again") from None


def _cells(code: Code, options: list[str], folder: Path, rank_by: RankBy) -> cells.Cells:
    """Run with these options and a version of the code. Errors: ResultsError with the last line of its error output."""
    done = subprocess.run(
        [*code.command, "run", *options, *(part for spec in code.solvers for part in ("--solver", spec)), "--out", folder],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"TMPDIR": str(folder.parent)},  # removed with it, also what a run leaves there that is interrupted
        preexec_fn=partial(process.die_with_parent, os.getpid()),  # or it would continue, and disturb later timings
    )
    if done.returncode:
        last_line = (done.stderr.strip().splitlines() or ["no error output"])[-1]
        raise ResultsError(f"confirm: {code.command[0]} exited with {done.returncode}: {last_line[:300]}")
    return cells.read(folder, rank_by)


def require_code(code: str) -> None:
    """Check the baseline's location. Errors: InputError if it names neither a folder nor a revision, or both."""
    require(bool(code), "code", "is empty, as a variable that is not set")
    revision = not code.startswith("-") and _git("rev-parse", "--verify", "--quiet", f"{code}^{{tree}}")
    if bool(revision) == Path(code).is_dir():
        problem = f"both a folder and a revision; write ./{code} or {code}^0" if revision else "neither a folder nor a revision"
        raise InputError(f"code: {code!r} is {problem} of the git repository in the current folder")


def baseline_code(code: str, named: list[str], scratch: Path) -> Code:
    """Return the baseline's code at `code`; a revision is unpacked in scratch. named: outside solvers, by absolute paths.

    Errors: InputError if it cannot be used.
    """
    folder = Path(code).absolute()
    if (folder / "bin" / "python").exists():
        require(not any(map(executable.is_command, named)), "code", "an environment holds no other executable; give a checkout")
        return Code([str(folder / "bin" / "python"), "-P", "-m", "frictionbench"], named)
    home = _home()
    folder = folder if folder.is_dir() else _unpacked(code, home, scratch / "code")
    ours, fork = ((place / "frictionbench" / "__main__.py").is_file() for place in (folder, home))
    keeps = [ours and not (fork and any(_place(path, home) for path in plugins.files(spec))) for spec in named]
    moved = [spec if keep else _moved(spec, home, folder) for keep, spec in zip(keeps, named, strict=True)]
    return Code([sys.executable, "-P", "-c", START, str(folder if ours else PACKAGE.parent)], moved)


def _moved(spec: str, home: Path, folder: Path) -> str:
    """Return the solver's file, or its command, with files replaced by those in another checkout of the repository at home."""
    if not plugins.defines_all(spec):
        raise InputError(f"code: {spec} is installed; give an environment with the baseline's version of it, like .venv-base")
    moved = spec
    for path in plugins.files(spec):
        place = _place(path, home)
        other = folder / place if place else path
        usable = other.is_file() and (place is not None or not plugins.is_file(spec))
        require(usable, "code", f"{path} is not in {folder}; give a checkout in which the baseline's version is built")
        moved = moved.replace(str(path), str(other))
    require(moved != spec, "code", f"{spec} is not of the repository, and both versions would run it")
    return moved


def _place(path: Path, home: Path) -> Path | None:
    """Return the path relative to home, even if it leads there through a link; None if it is elsewhere."""
    ways = path, path.parent.resolve() / path.name, path.resolve()
    return next((way.relative_to(home) for way in ways if way.is_relative_to(home)), None)


def _home() -> Path:
    """Return the top of the git repository of the current folder, or the current folder outside a repository."""
    top = _git("rev-parse", "--show-toplevel")
    return Path(top.decode().strip()) if top else Path.cwd()


def _unpacked(revision: str, home: Path, folder: Path) -> Path:
    archive = _git("-C", str(home), "archive", "--format=tar", revision) or b""  # at the top, or it would lack other folders
    require(bool(archive), "code", f"git cannot unpack {revision!r}")
    try:
        with tarfile.open(fileobj=io.BytesIO(archive)) as packed:
            packed.extractall(folder, filter="data")
    except tarfile.TarError as error:  # such as a link that leads outside
        raise InputError(f"code: {revision} cannot be unpacked ({error}); give a checkout of it") from None
    return folder


def _git(*arguments: str) -> bytes | None:
    try:
        return subprocess.run(["git", *arguments], capture_output=True, check=True, timeout=60).stdout
    except (OSError, subprocess.SubprocessError):
        return None
