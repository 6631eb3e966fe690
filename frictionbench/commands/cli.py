"""The command line. Exit codes: 0 done, 1 a regression (compare) or a failed check (check-solver), 2 unusable input or output,
3 an error of frictionbench itself, 128 + n ended by signal n; 141 also if the reader of a pipe has ended.

Large imports are inside the commands that need them, so that --help is fast.
"""

import os
import re
import shlex
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from typer.core import TyperArgument, TyperCommand

from frictionbench.commands import options
from frictionbench.harness.streams import Unwritable, standard_streams
from frictionbench.results.conventions import DEFAULT_SCHEME, RankBy
from frictionbench.results.files import json_text, printable

app = typer.Typer(
    help="Compare solvers for the friction LCPs of rigid-body dynamics. To begin: frictionbench solve stack --solver lemke",
    no_args_is_help=True,
    add_completion=True,
    rich_markup_mode=None,  # otherwise [blocks=5] would be read as markup
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
_SIGNALS = [signal.SIGINT, signal.SIGTERM]
if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # nohup ignores it
    _SIGNALS.append(signal.SIGHUP)


class _Command(TyperCommand):
    """A command whose help does not show the Python types of arguments, such as list[Path], and whose error messages replace
    those of the library that parses values for typer."""

    def make_context(self, *given: Any, **named: Any) -> Any:
        try:
            return super().make_context(*given, **named)
        except Exception as error:
            if getattr(error, "option_name", "") == "--suite":  # the class of this error is not public in typer
                raise typer.BadParameter("--suite: the suite is an argument, as in `frictionbench run smoke`") from None
            if isinstance(error, typer.BadParameter):
                error.message = _reworded(error)
            raise

    def get_params(self, ctx: Any) -> Any:
        params = super().get_params(ctx)
        for argument in (each for each in params if isinstance(each, TyperArgument)):
            vars(argument)["display_type_rich"] = lambda ctx: None
        return params


_command = partial(app.command, cls=_Command)


def _version(requested: bool) -> None:
    if requested:
        from importlib.metadata import version

        typer.echo(f"frictionbench {version('frictionbench')}")
        raise typer.Exit


@app.callback()
def about(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")] = False,
) -> None:
    pass


@_command("list")
def list_(what: options.Listing, as_json: options.AsJson = False) -> None:
    """List the scenes, the solvers or the suites."""
    from frictionbench.commands.listing import listed, show

    if as_json:
        typer.echo(json_text(listed(what)))
    else:
        show(what)


@_command()
def run(
    suite: options.Suite = None,
    scene: options.Scenes = None,
    solver: options.Solvers = None,
    tol: options.Tolerances = None,
    time_limit: options.SuitesLimit = None,
    jobs: options.Jobs = None,
    data: options.Data = None,
    cluster: options.Cluster = None,
    out: options.Out = None,
    config: options.Config = None,
    all_solvers: Annotated[bool, typer.Option("--all-solvers", help="Every installed solver; this may take long.")] = False,
    retake: Annotated[
        bool, typer.Option("--retake", help="Run again the cells that shared their core with another process, or timed out.")
    ] = False,
    quiet: options.Quiet = False,
) -> None:
    """Run a suite, or the part of it that the options select.

    The same command resumes an interrupted run.
    """
    from frictionbench.commands.summary import folder_for, summary
    from frictionbench.harness.maps import run_maps
    from frictionbench.harness.plans.choose import RunOptions, choose, read_options
    from frictionbench.harness.progress import Progress
    from frictionbench.harness.run import drop_disturbed, run as run_plan
    from frictionbench.harness.workers.inputs import load_plugins, require_buildable

    progress = Progress(quiet=quiet)
    wanted = RunOptions(suite, scene, solver, tol, time_limit, data, all_solvers or None, str(out) if out else None)
    if config:
        wanted = wanted.before(read_options(config, solver))
    variants, plugins = load_plugins(wanted.solver or [])
    plan = choose(wanted, variants, plugins)
    if wanted.scene:
        named = [(source.scene, source.parameters) for source in plan.sources]
        require_buildable([*named, *((batch.scene, batch.parameters) for batch in plan.batches)])
    folder = Path(wanted.out) if wanted.out else folder_for(plan)
    begin, workers = run_maps if plan.maps else run_plan, _jobs(jobs)
    with _resumable(folder):
        if retake:
            drop_disturbed(plan, folder)
        begin(plan, folder, workers, progress, cluster)
    typer.echo(summary(folder))


@_command()
def report(
    folder: options.Folder,
    paper: Annotated[bool, typer.Option("--paper", help="Also write figures, tables and captions for LaTeX.")] = False,
    solvers: Annotated[str | None, typer.Option("--solvers", metavar="A,B", help="For the paper: only these solvers.")] = None,
    scenes: Annotated[str | None, typer.Option("--scenes", metavar="A,B", help="For the paper: only these scenes.")] = None,
    figures: Annotated[str | None, typer.Option("--figures", metavar="A,B", help="For the paper: only these figures.")] = None,
    width: Annotated[
        float | None,
        typer.Option(
            "--width", metavar="85mm|3in|241pt", parser=options.parse_length, help="For the paper; by default 3.35in."
        ),
    ] = None,
    font: Annotated[
        Literal["serif", "sans"] | None,
        typer.Option("--font", metavar="serif|sans", help="For the paper: its typeface, serif by default."),
    ] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Also write the report's tables as Markdown.")] = False,
    rank_by: options.By = RankBy.BODIES,
    budget: options.Budget = None,
) -> None:
    """Make the HTML report of a results folder."""
    from frictionbench.harness.progress import Progress
    from frictionbench.problems.check import require
    from frictionbench.reports.batches import has_batches
    from frictionbench.reports.page import write_report
    from frictionbench.reports.run import read_run

    chosen = solvers or scenes or figures or width or font
    require(paper or not chosen, "paper", "--solvers, --scenes, --figures, --width and --font are for the paper: give --paper")
    if paper or markdown:
        require(not has_batches(folder), "paper" if paper else "markdown", "a run of batches has only a page")
    run, progress = read_run(folder, rank_by, budget), Progress()
    if paper:
        from frictionbench.reports.paper import chart_names, restricted, write_paper

        shown = restricted(run, "scenes", options.split_names(scenes)) if scenes else run
        shown = restricted(shown, "solvers", options.split_names(solvers)) if solvers else shown
        wanted = chart_names(shown, options.split_names(figures) if figures else None)
        written = write_paper(folder, shown, progress.counted("figures", wanted, len(wanted)), width or 3.35, font or "serif")
        typer.echo(f"paper:  {written}, of {'; '.join(shown.looks)}. captions.tex has captions, references.bib references")
    if not (paper and figures):
        progress.tell("the page is being drawn: some seconds, for a large run a minute")
        typer.echo(f"report: {write_report(folder, run)}")
    if markdown:
        from frictionbench.reports.markdown import write_markdown

        typer.echo(f"markdown: {write_markdown(folder, run)}")


@_command()
def compare(
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR", help="A baseline file or results folder, then a results folder; any number with --history."
        ),
    ],
    accept: Annotated[bool, typer.Option("--accept", help="Write the run DIR as the baseline BASELINE.")] = False,
    history: Annotated[bool, typer.Option("--history", help="Show verdicts, work and times of all runs over time.")] = False,
    confirm: Annotated[bool, typer.Option("--confirm", help="Run the cells with alerts again before exiting with 1.")] = False,
    code: Annotated[
        str | None,
        typer.Option(
            "--code",
            metavar="REVISION|DIR",
            help="With --confirm: the baseline's code, run alternately with this code to compare times: a git revision, a "
            "checkout, or an environment in which it is installed.",
        ),
    ] = None,
    solver: options.Trusted = None,
    slowdown: Annotated[
        float, typer.Option("--slowdown", metavar="RATIO", min=1, help="Ratio of times above which a solver counts as slower.")
    ] = 1.1,
    no_times: Annotated[bool, typer.Option("--no-times", help="Do not compare times.")] = False,
    rank_by: options.By = RankBy.BODIES,
    out: Annotated[Path | None, typer.Option("--out", metavar="FOLDER", help="Also write Markdown, JSON, JUnit XML.")] = None,
) -> None:
    """Compare two runs as Markdown, or show runs over time.

    Exit code 0: nothing is worse; 1: a regression; 2: unusable input.
    """
    from frictionbench.problems.check import require
    from frictionbench.reports.comparison.files import write_files
    from frictionbench.reports.comparison.history import history as over_time
    from frictionbench.reports.comparison.markdown import markdown, summarise
    from frictionbench.results.compare import Limits, accept as accept_run, compare as compare_runs

    only = "neither --history nor --accept can be combined with the other, with --confirm or with --out"
    require(history + accept + (confirm or out is not None) < 2, "history" if history else "accept", only)
    if history:
        typer.echo(over_time(runs))
        return
    require(len(runs) == 2, "DIR", "give a baseline and one results folder, or --history for a table of many")
    baseline, folder = runs
    require(not folder.is_file(), "DIR", f"{folder} is a file; the second DIR is the results folder of a run")
    if accept:
        before, accepted = accept_run(folder, baseline)
        if before is not None:
            typer.echo(markdown(before))
        typer.echo(accepted)
        return
    require(confirm or not (code or solver), "confirm", "--code and --solver say what --confirm runs; give it as well")
    require(slowdown < float("inf"), "slowdown", "must be finite")
    limits = Limits(slowdown, times=not no_times, rank_by=rank_by)
    comparison = compare_runs(baseline, folder, limits)
    if confirm:
        from frictionbench.commands.confirm import confirmed

        comparison = confirmed(comparison, limits, solver or [], code, lambda line: typer.echo(line, err=True))
    typer.echo(markdown(comparison))
    summarise(comparison)
    if out:
        write_files(comparison, out)
    raise typer.Exit(comparison.exit_code)


@_command()
def solve(
    problem: Annotated[str, typer.Argument(metavar="FILE|SCENE", help="A problem file, or a scene like 'stack[blocks=5]'.")],
    solver: options.Solvers = None,
    tol: options.Tolerance = 1e-8,
    time_limit: options.Limit = 10.0,
    jobs: options.Jobs = None,
    rank_by: options.ByOfProblem = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Solve one problem with every solver and show a table."""
    from frictionbench.commands.single import solve_one
    from frictionbench.harness.progress import Progress

    wanted = (problem, solver or [], tol, time_limit, _jobs(jobs))
    solve_one(*wanted, rank_by=rank_by, progress=Progress(quiet=quiet), as_json=as_json)


@_command()
def judge(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER|FILE", help="Steps of an engine, *.npz, or one of them.")],
    against: Annotated[
        list[str] | None, typer.Option("--against", metavar="SOLVER", help="Another solver on the same steps; may be repeated.")
    ] = None,
    tol: options.Tolerance = 1e-8,
    time_limit: options.Limit = 10.0,
    jobs: options.Jobs = None,
    out: options.Out = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Judge how exact an engine's own steps are.

    Its impulses are measured by Coulomb's law, and exact solvers answer the same steps.
    """
    from frictionbench.commands.judge import as_data, summary
    from frictionbench.harness.judge import prepared
    from frictionbench.harness.progress import Progress
    from frictionbench.harness.run import run as run_plan
    from frictionbench.harness.workers.inputs import load_plugins
    from frictionbench.reports.judgement import write_judgement

    variants, plugins = load_plugins(against or [])
    progress = Progress(quiet=quiet)
    workers = _jobs(jobs)
    plan, written = prepared(folder, variants, plugins, tol, time_limit, workers, out, progress)
    with _resumable(written):
        run_plan(plan, written, workers, progress)
    page = write_judgement(written)
    typer.echo(json_text(as_data(written)) if as_json else f"{summary(written)}\nreport: {page}")


@_command()
def export(
    problems: Annotated[
        str, typer.Argument(metavar="SCENE|DIR|fclib/FAMILY", help="A scene, a results folder or a recorded family.")
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE|FOLDER", help="A file, .hdf5 or .npz, or a folder for several.")
    ] = None,
    pick: Annotated[
        int,
        typer.Option("--pick", metavar="N", min=0, help="Number of problems, spread over the motion; 0: the first problem."),
    ] = 0,
) -> None:
    """Write problems in FCLIB's HDF5 format, or as .npz.

    fclib/FAMILY downloads recorded problems of FCLIB's collection into the user's cache, verified by size and sha256; fclib/
    lists all.
    """
    from frictionbench.commands.export import export as export_problems, fetch
    from frictionbench.problems.check import InputError, require

    if problems.startswith("fclib/"):
        require(out is None, "out", "a family of fclib is fetched into the user's cache")
        fetch(problems)
        return
    if out is None:
        raise InputError("out: name the file or folder to write with --out")
    try:
        for path in export_problems(problems, out, pick):
            typer.echo(path)
    except _Stopped as stopped:
        stopped.add_note("run the same command again to go on: files that were named are whole")
        raise


@_command()
def show(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="Like stack or 'stack[blocks=5]'.")],
    solver: Annotated[
        str | None, typer.Option("--solver", metavar="SOLVER|FILE", help="By default lemke, in space interior_point.")
    ] = None,
    scheme: options.Scheme = DEFAULT_SCHEME,
    steps: Annotated[int | None, typer.Option("--steps", metavar="N", min=1, help="By default the scene's duration.")] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.html", help="By default named by the scene.")] = None,
) -> None:
    """Animate a scene on an HTML page.

    It shows bodies, contact impulses, friction cones and the energy balance.
    """
    from frictionbench.commands.show import energy_balance, page_name, recorded
    from frictionbench.reports.animation import write_animation

    motion = recorded(scene, solver, scheme, steps)
    typer.echo(f"animation: {write_animation(motion, out or Path(page_name(scene, solver and motion.solver, scheme)))}")
    typer.echo(energy_balance(motion))
    if motion.ended:
        typer.echo(f"the motion ends after {len(motion.times) - 1} steps: {motion.ended}", err=True)


@_command("map")
def map_(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="Like painleve_rod or 'stack[push=1]'.")],
    x: Annotated[str, typer.Option("--x", metavar="PARAMETER=FROM:TO:N", help="Like friction=.1:3:30.")],
    y: Annotated[str, typer.Option("--y", metavar="PARAMETER=FROM:TO:N", help="Like mass_ratio=log:1e-6:1e6:13.")],
    solver: options.Solvers = None,
    tol: options.Tolerance = 1e-6,
    time_limit: options.Limit = 1.0,
    scheme: options.Scheme = DEFAULT_SCHEME,
    steps: Annotated[int, typer.Option("--steps", metavar="N", min=0, help="Steps in closed loop; 0: the first problem.")] = 0,
    jobs: options.Jobs = None,
    out: options.Out = None,
    quiet: options.Quiet = False,
) -> None:
    """Draw a failure map of a scene over two of its parameters.

    Every solver runs on a grid that is refined where verdicts differ.
    """
    from frictionbench.commands.summary import folder_for, verdict_counts
    from frictionbench.harness.maps import corners, plan_map, run_maps
    from frictionbench.harness.progress import Progress
    from frictionbench.harness.workers.inputs import load_plugins, require_buildable
    from frictionbench.reports.page import write_report
    from frictionbench.results.store import read_table

    variants, plugins = load_plugins(solver or [])
    plan = plan_map(scene, x, y, variants, plugins, tol, time_limit, scheme, steps)
    require_buildable([(spec.scene, spec.at(corner)) for spec in plan.maps for corner in corners(spec)])
    folder, progress = out or folder_for(plan), Progress(quiet=quiet)
    with _resumable(folder):
        run_maps(plan, folder, _jobs(jobs), progress)
    typer.echo(verdict_counts("cells (grid point and solver)", read_table(folder, "simulations" if steps else "solves")))
    typer.echo(f"report: {write_report(folder)}")


@_command("check-solver")
def check_solver(
    solver: Annotated[
        list[str], typer.Argument(metavar="FILE|NAME...", help="Files that define solvers, or names; with all their variants.")
    ],
    jobs: options.Jobs = None,
    quiet: options.Quiet = False,
) -> None:
    """Check a solver against the contract.

    Shows what is wrong and how to correct it. Exit code 0: all checks passed; 1: a check failed.
    """
    from frictionbench.harness.contract.examine import examine, format_findings
    from frictionbench.harness.progress import Progress

    results = examine(solver, _jobs(jobs), Progress(quiet=quiet))
    typer.echo(format_findings(results))
    raise typer.Exit(int(any(one.violations for one in results)))


@_command()
def rerun(
    folder: options.Folder,
    row: options.Row = "",
    solver: options.Trusted = None,
    shrink: Annotated[bool, typer.Option("--shrink", help="Remove contacts while it still fails, and save the rest.")] = False,
) -> None:
    """Run one cell again, or reduce its problem."""
    if not shrink or not row:
        from frictionbench.commands.single import show_rerun

        show_rerun(folder, row, solver or [])
        return
    from frictionbench.commands.shrink import shrink as shrink_row

    path, problem, trials, command = shrink_row(folder, row, solver or [], lambda line: typer.echo(line, err=True))
    typer.echo(f"reduced to {problem.contacts} contacts in {trials} trials: {path}\nsolve it: {command}")


def _jobs(jobs: int | None) -> int:
    """Return the number of workers. By default one core is left to this process and the system, which would disturb timings."""
    from frictionbench.harness.process import cores, require_linux
    from frictionbench.problems.check import require

    require_linux()
    most = len(cores())
    require(jobs is None or jobs <= most, "jobs", f"at most {most} on this machine, one per core")
    return jobs or max(1, most - 1)


class _Stopped(BaseException):
    """A signal interrupted the command; the argument is its number."""


def _stop(number: int, _: Any) -> None:
    for same in _SIGNALS:
        signal.signal(same, signal.SIG_IGN)  # further signals do not interrupt the clean-up
    raise _Stopped(number)


def _reworded(error: typer.BadParameter) -> str:
    """Return the message for an unusable argument: the value, and what is wrong with it."""
    detail: dict[str, Any] = next(iter(getattr(error.__cause__, "errors", list)()), {"type": "", "input": ""})
    bounds = detail.get("ctx", {})
    words = {
        "float_parsing": "is not a number",
        "int_parsing": "is not a whole number",
        "greater_than_equal": f"is below {bounds.get('ge')}",
    }
    if detail["type"] not in words:
        return error.message.removeprefix("Value error, ")
    return f"{detail['input']!r} {words[detail['type']]}"


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    """Print how to resume the run if it is interrupted."""
    try:
        yield
    except _Stopped as stopped:
        stopped.add_note("run the same command again to resume")
        stopped.add_note(f"report of the results so far: frictionbench report {shlex.quote(str(folder))}")
        raise


def main() -> None:
    """Run the command line. Errors of input are printed as one line, errors of this program in full."""
    with standard_streams():
        try:
            _run()
        except Unwritable:
            raise
        except Exception as error:  # Python would exit with 1, which means a regression
            if traceback.extract_tb(error.__traceback__)[-1].filename.endswith("numba/core/caching.py"):
                from frictionbench.solvers.plugins import describe_error

                typer.echo(f"frictionbench: {describe_error(error)}", err=True)
                sys.exit(2)
            traceback.print_exc()
            sys.exit(3)


def _run() -> None:
    wrong = {
        "python -OO removes descriptions that commands print": sys.flags.optimize > 1,
        "NUMBA_NUM_THREADS must be at least 1": re.fullmatch(r"-\d+|0+", os.environ.get("NUMBA_NUM_THREADS", "").strip()),
        "a name that is not UTF-8 cannot be stored": any("\udc80" <= c <= "\udcff" for word in sys.argv for c in word),
    }
    for told, applies in wrong.items():
        if applies:
            typer.echo(f"frictionbench: {told}", err=True)
            sys.exit(2)
    try:
        for number in _SIGNALS:
            signal.signal(number, _stop)
        app()
    except (ValueError, OSError) as error:
        from frictionbench.problems import InputError
        from frictionbench.results.files import ResultsError

        if not isinstance(error, InputError | ResultsError | OSError):
            raise
        typer.echo(f"frictionbench: {_message(error)}", err=True)
        sys.exit(2)
    except _Stopped as stopped:
        number = stopped.args[0]
        notes = [f"interrupted by {signal.Signals(number).name}", *getattr(stopped, "__notes__", [])]
        with suppress(Unwritable):  # the terminal may be closed
            typer.echo(f"\nfrictionbench: {'; '.join(notes)}", err=True)
        sys.exit(128 + number)
    finally:
        for number in _SIGNALS:  # where no handler reports it, a signal ends the process at once
            signal.signal(number, signal.SIG_DFL)


def _message(error: Exception) -> str:
    """Return the error's message; for an error of the operating system the file and the reason."""
    if isinstance(error, OSError) and error.filename and error.strerror:
        return printable(f"{error.filename}: {error.strerror}")
    return "\n".join(map(printable, str(error).splitlines()))
