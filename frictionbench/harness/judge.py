"""Judging the steps of an engine: each step's own answer, then a run of our solvers, and of others, on the same problems.

The files are read and judged in workers. The problems by which they are judged are the sources of a run like any other, which
an interruption does not lose.
"""

import json
import re
import tempfile
from hashlib import sha256
from pathlib import Path
from shutil import move

from frictionbench.harness.cells import worker
from frictionbench.harness.cells.judgement import FOLDER
from frictionbench.harness.plans.plan import MEMORY_LIMIT, Plan, Plugin, Source
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import COLLECT_SECONDS, open_folder
from frictionbench.harness.run import run as run_plan
from frictionbench.harness.workers.pool import Pool
from frictionbench.harness.workers.task import Task
from frictionbench.problems import InputError
from frictionbench.problems.check import require
from frictionbench.results.files import subfolder
from frictionbench.results.judgement import Judgement, checked, touching, write_judgements

EXACT = "hybrid"  # our solver of Coulomb's law for any problem, which stands beside the engine


def judge(
    folder: Path,
    against: tuple[str, ...],
    plugins: tuple[Plugin, ...],
    tol: float,
    time_limit: float,
    jobs: int,
    out: Path | None = None,
) -> Path:
    """Judge the steps in folder/*.npz and run EXACT and the solvers `against` on them; the results folder.

    out: by default one below runs/ that is named by what is judged. Errors: InputError naming the folder or the file that
    cannot be used, and as of harness.run.run.
    """
    paths = sorted(folder.glob("*.npz"), key=_natural)
    require(bool(paths), "folder", f"{folder} holds no steps of an engine, *.npz; docs/engines.md says how to write them")
    progress = Progress()
    with tempfile.TemporaryDirectory() as name:
        found = _judgements(paths, Path(name), jobs, progress)
        require(bool(touching(found)), "folder", f"no step in {folder} has a contact")
        solvers = tuple(dict.fromkeys((EXACT, *against)))
        out = out or Path("runs") / f"judge-{_digest([one.problem for one in found], solvers, tol, time_limit)}"
        plan = Plan("judge", _sources(folder, found, out), solvers, (tol,), time_limit=time_limit, plugins=plugins)
        open_folder(plan, out)
        for path in (Path(name) / FOLDER).iterdir():
            move(path, subfolder(out, FOLDER) / path.name)
    write_judgements(out, found)
    run_plan(plan, out, jobs, progress)
    return out


def _judgements(paths: list[Path], scratch: Path, jobs: int, progress: Progress) -> list[Judgement]:
    """The judgements in the order of the paths. Errors: InputError naming the first file that cannot be judged."""
    tasks = [Task(path.name, worker.run_judgement, (str(path.absolute()), COLLECT_SECONDS), COLLECT_SECONDS) for path in paths]
    found: dict[str, Judgement] = {}
    with Pool(scratch, jobs, (), MEMORY_LIMIT) as pool, progress.stage("steps", len(tasks), 0) as stage:
        for outcome in pool.run(tasks, stage.started, stage.compiling):
            if outcome.failure:
                raise InputError(f"{outcome.task.arguments[0]}: cannot be judged ({outcome.reason})")
            if refused := outcome.value.get("refused"):
                raise InputError(refused)
            found[outcome.task.name] = checked(outcome.value)
            stage.finished(outcome.task)
    return [found[path.name] for path in paths]


def _sources(folder: Path, found: list[Judgement], out: Path) -> tuple[Source, ...]:
    """The problems by which the steps with contacts are judged, each problem once."""
    steps = {one.problem: one.file for one in reversed(touching(found))}
    stored = out.absolute() / FOLDER
    name = folder.resolve().name
    return tuple(Source(name, {"file": file}, file=str(stored / f"{problem}.npz")) for problem, file in reversed(steps.items()))


def _digest(*settings: object) -> str:
    return sha256(json.dumps(settings).encode()).hexdigest()[:8]


def _natural(path: Path) -> list[tuple[int, str]]:
    """A key that sorts step_2 before step_10."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]
