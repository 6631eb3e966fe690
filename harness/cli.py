"""The command line. Exit codes: 0 done, 1 a regression (compare), 2 unusable input, 128 + n ended by signal n.

Everything heavy is imported inside the command that needs it, so that --help answers at once.
"""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from frictionbench.harness.commands import options
from frictionbench.results.conventions import DEFAULT_SCHEME

app = typer.Typer(
    help="Compare solvers for the friction LCPs of rigid-body dynamics. First: frictionbench solve stack",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # which reads [blocks=5] as markup
    pretty_exceptions_enable=False,
)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"frictionbench {version('frictionbench')}")
        raise typer.Exit


@app.callback()
def about(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")] = False,
) -> None:
    pass


@app.command("list")
def list_(what: options.Listing) -> None:
    """List the scenes, the solvers or the suites."""
    from frictionbench.harness.commands import listing

    listing.show(what)


@app.command()
def run(
    suite: options.Suite = "standard",
    scene: options.Scenes = None,
    solver: options.Solvers = None,
    tol: options.Tolerances = None,
    time_limit: options.SuitesLimit = None,
    jobs: options.Jobs = None,
    data: options.Data = None,
    cluster: options.Cluster = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Results folder; by default one below runs/ for these very settings."),
    ] = None,
    retake: Annotated[
        bool, typer.Option("--retake", help="Run again the cells of an earlier run that did not have their core to themselves.")
    ] = False,
) -> None:
    """Run a suite, or what of it the options choose.

    The same command goes on with a run that was broken off.
    """
    from frictionbench.harness.commands.summary import folder_for, summary
    from frictionbench.harness.plans.choose import choose
    from frictionbench.harness.progress import Progress
    from frictionbench.harness.run import drop_disturbed
    from frictionbench.harness.run import run as run_plan
    from frictionbench.harness.workers.plugins import load_plugins

    variants, plugins = load_plugins(solver or [])
    plan = choose(suite, scene or [], variants, tol, time_limit, plugins, tuple(data or ()))
    folder = out or folder_for(plan)
    with _goes_on(folder):
        if retake:
            drop_disturbed(plan, folder)
        if plan.maps:
            from frictionbench.harness.run_maps import run_maps

            run_maps(plan, folder, _jobs(jobs), Progress(), cluster)
        else:
            run_plan(plan, folder, _jobs(jobs), Progress(), cluster)
    typer.echo(summary(folder))


@app.command()
def report(
    folder: options.Folder,
    paper: Annotated[bool, typer.Option("--paper", help="Also figures, tables, captions and references for LaTeX.")] = False,
    solvers: Annotated[
        str | None, typer.Option("--solvers", metavar="A,B,...", help="For the paper: only these, by their names.")
    ] = None,
    width: Annotated[
        float,
        typer.Option(
            "--width", metavar="85mm|3.35in|241pt", parser=options.parse_length, help="For the paper: a column's width."
        ),
    ] = 3.35,
    font: Annotated[
        Literal["serif", "sans"], typer.Option("--font", metavar="serif|sans", help="For the paper: its typeface.")
    ] = "serif",
    markdown: Annotated[bool, typer.Option("--markdown", help="Also the run's figures as Markdown.")] = False,
) -> None:
    """Make the HTML report of a results folder."""
    from frictionbench.reports.page import write_report
    from frictionbench.reports.run import read_run

    run = read_run(folder)
    typer.echo(f"report: {write_report(folder, run)}")
    if paper:
        from frictionbench.reports.latex import Layout
        from frictionbench.reports.paper import chosen, write_paper

        written = write_paper(folder, chosen(run, options.split_names(solvers)) if solvers else run, Layout(width, font))
        typer.echo(f"paper:  {written}, its preview.tex shows all; references in references.bib")
        if not any(written.glob("*.pgf")):
            typer.echo("no PGF: pdflatex is not installed, which measures its texts")
    if markdown:
        from frictionbench.reports.markdown import write_markdown

        typer.echo(f"figures: {write_markdown(folder, run)}")


@app.command()
def compare(
    baseline: Annotated[Path, typer.Argument(metavar="BASELINE", help="A baseline's text, or a results folder.")],
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A results folder. Both may be results of pytest-benchmark.")],
    confirm: Annotated[bool, typer.Option("--confirm", help="Run the alerting cells again before exit 1.")] = False,
    code: Annotated[
        str | None,
        typer.Option(
            "--code",
            metavar="REVISION|DIR",
            help="With --confirm: the baseline's code, to run in turn with this one and compare times: a git revision, a "
            "checkout, or an environment that has it.",
        ),
    ] = None,
    solver: options.Trusted = None,
    slowdown: Annotated[
        float,
        typer.Option("--slowdown", metavar="RATIO", min=1, help="Of times, up to which nothing is slower."),
    ] = 1.1,
    growth: Annotated[
        float,
        typer.Option("--growth", metavar="RATIO", min=1, help="Of work, up to which nothing has grown."),
    ] = 1.05,
    alpha: Annotated[
        float,
        typer.Option("--alpha", metavar="P", min=0, max=1, help="Chance of error of the times' intervals."),
    ] = 0.05,
    no_times: Annotated[bool, typer.Option("--no-times", help="Leave times out.")] = False,
    known: Annotated[
        Path | None, typer.Option("--known", metavar="FILE", help="Acknowledged changes with their reasons, in TOML.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FOLDER", help="Write it as Markdown, JSON, benchmark JSON and JUnit XML.")
    ] = None,
) -> None:
    """Compare two runs as Markdown.

    Exit 0 nothing worse, 1 a regression, 2 unusable input.
    """
    from frictionbench.reports.comparison.files import write_files
    from frictionbench.reports.comparison.markdown import markdown, summarise
    from frictionbench.results.compare import Limits
    from frictionbench.results.compare import compare as compare_runs
    from frictionbench.results.known import acknowledge, read

    acknowledged = read(known) if known else []
    limits = Limits(slowdown, growth, alpha, not no_times)
    comparison = compare_runs(baseline, folder, limits)
    if confirm:
        from frictionbench.harness.commands.confirm import confirmed

        comparison = confirmed(comparison, limits, solver or [], code, lambda line: typer.echo(line, err=True))
    comparison = acknowledge(comparison, acknowledged)
    typer.echo(markdown(comparison))
    summarise(comparison)
    if out:
        write_files(comparison, out)
    raise typer.Exit(comparison.exit_code)


@app.command()
def accept(
    folder: options.Folder,
    baseline: Annotated[
        Path | None, typer.Argument(metavar="BASELINE", help="The text to write; baselines/SUITE.tsv by default.")
    ] = None,
) -> None:
    """Make a run the baseline that others are compared with.

    Shows what that changes.
    """
    from frictionbench.harness.commands.accept import accept as accept_run
    from frictionbench.reports.comparison.markdown import markdown

    before, told = accept_run(folder, baseline)
    if before is not None:
        typer.echo(markdown(before))
    typer.echo(told)


@app.command()
def history(folders: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Results folders and baselines.")]) -> None:
    """Show verdicts, work and times of runs over time."""
    from rich.console import Console

    from frictionbench.reports.comparison.history import history as table_of

    console, table = Console(), table_of(folders)
    (console if console.is_terminal else Console(width=10**6)).print(table)  # nothing is folded in a pipe


@app.command()
def solve(
    problem: Annotated[str, typer.Argument(metavar="FILE|SCENE", help="A problem file, or a scene like 'stack[blocks=5]'.")],
    solver: options.Solvers = None,
    tol: options.Tolerance = 1e-8,
    time_limit: options.Limit = 10.0,
    jobs: options.Jobs = None,
) -> None:
    """Put every solver to one problem and show a table."""
    from frictionbench.harness.commands.single import solve_one

    solve_one(problem, solver or [], tol, time_limit, _jobs(jobs))


@app.command()
def export(
    problems: Annotated[str, typer.Argument(metavar="SCENE|DIR", help="A scene, or a results folder.")],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FILE.hdf5|FOLDER", help="One file, or a folder where there are several.")
    ],
    pick: Annotated[
        int,
        typer.Option("--pick", metavar="N", min=0, help="Problems spread over its motion; 0: the first."),
    ] = 0,
) -> None:
    """Write problems in FCLIB's HDF5 format, for others to solve."""
    from frictionbench.harness.commands.export import export as export_problems

    for path in export_problems(problems, out, pick):
        typer.echo(path)


@app.command()
def fetch(
    family: Annotated[str, typer.Argument(metavar="fclib/FAMILY", help="Like fclib/Capsules; `fclib/` lists those known.")],
) -> None:
    """Download recorded problems of FCLIB's collection.

    They are checked by size and sha256 and go into the user's cache.
    """
    from frictionbench.harness.commands.fetch import fetch as fetch_family

    fetch_family(family)


@app.command()
def show(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="Like stack or 'stack[blocks=5]'.")],
    solver: Annotated[str, typer.Option("--solver", metavar="SOLVER", help="A solver, or a file that defines one.")] = "lemke",
    scheme: options.Scheme = DEFAULT_SCHEME,
    steps: Annotated[
        int | None,
        typer.Option("--steps", metavar="N", min=1, help="The scene's whole duration by default."),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.html", help="SCENE.html by default.")] = None,
) -> None:
    """Animate a scene on an HTML page.

    It shows bodies, contact impulses, friction cones and the ledger of energy.
    """
    from frictionbench.harness.commands.show import recorded
    from frictionbench.reports.animation import write_animation

    motion = recorded(scene, solver, scheme, steps)
    typer.echo(f"animation: {write_animation(motion, out or Path(f'{motion.scene}.html'))}")
    if motion.ended:
        typer.echo(f"it ends after {len(motion.times) - 1} steps: {motion.ended}", err=True)


@app.command("map")
def map_(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="Like painleve_rod or 'stack[push=1]'.")],
    x: Annotated[str, typer.Option("--x", metavar="PARAMETER=FROM:TO:N", help="Like friction=.1:3:30.")],
    y: Annotated[str, typer.Option("--y", metavar="PARAMETER=FROM:TO:N", help="Like mass_ratio=log:1e-6:1e6:13.")],
    solver: options.Solvers = None,
    tol: Annotated[str, typer.Option("--tol", metavar="T", help="Residual to ask for.")] = "1e-6",
    time_limit: options.Limit = 1.0,
    scheme: options.Scheme = DEFAULT_SCHEME,
    steps: Annotated[
        int,
        typer.Option("--steps", metavar="N", min=0, help="Steps in closed loop; 0 for the first problem alone."),
    ] = 0,
    jobs: options.Jobs = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Results folder; by default one below runs/ for these very settings."),
    ] = None,
) -> None:
    """Draw a failure map of a scene over two of its parameters.

    Every solver is tried on a grid that is refined where verdicts differ.
    """
    from frictionbench.harness.commands.map import plan_map
    from frictionbench.harness.commands.summary import folder_for
    from frictionbench.harness.progress import Progress
    from frictionbench.harness.run_maps import run_maps
    from frictionbench.harness.workers.plugins import load_plugins
    from frictionbench.reports.page import write_report

    variants, plugins = load_plugins(solver or [])
    plan = plan_map(scene, x, y, variants, plugins, tol, time_limit, scheme, steps)
    folder = out or folder_for(plan)
    with _goes_on(folder):
        run_maps(plan, folder, _jobs(jobs), Progress())
    typer.echo(f"report: {write_report(folder)}")


@app.command("check-solver")
def check_solver(
    solver: Annotated[
        list[str], typer.Argument(metavar="FILE|NAME...", help="A file that defines solvers, or names; all variants of a name.")
    ],
    jobs: options.Jobs = None,
) -> None:
    """Hold a solver to the contract.

    Says what is wrong with it, and what to do; exit 0 where it keeps all of it, else 1.
    """
    from frictionbench.harness.contract.examine import examine, told

    found = examine(solver, _jobs(jobs))
    typer.echo(told(found))
    raise typer.Exit(int(any(one.complaints for one in found)))


@app.command()
def rerun(folder: options.Folder, row: options.Row, solver: options.Trusted = None) -> None:
    """Run one cell of a results folder again and show both rows."""
    from frictionbench.harness.commands.single import show_rerun

    show_rerun(folder, row, solver or [])


@app.command()
def shrink(folder: options.Folder, row: options.Row, solver: options.Trusted = None) -> None:
    """Make a failing cell's problem as small as it can be.

    It is kept as a file, which still fails.
    """
    from frictionbench.harness.commands.shrink import shrink as shrink_row

    path, problem, trials = shrink_row(folder, row, solver or [])
    typer.echo(f"{problem.contacts} contacts and {len(problem.free_velocity)} velocities left after {trials} trials: {path}")
    typer.echo(f"again: frictionbench solve {path}")


def _jobs(jobs: int | None) -> int:
    from frictionbench.harness.process import cores, require_linux
    from frictionbench.problems import InputError

    require_linux()
    most = len(cores())
    if jobs is not None and jobs > most:
        raise InputError(f"jobs: at most {most} here, one core for each")
    return jobs or most


class _Stopped(BaseException):
    """A signal asked for the end; the argument is its number."""


def _stop(number: int, _: Any) -> None:
    for same in _SIGNALS:
        signal.signal(same, signal.SIG_IGN)  # what is under way ends in order
    raise _Stopped(number)


@contextmanager
def _goes_on(folder: Path) -> Iterator[None]:
    """Say where a run goes, and of one that is stopped how it goes on."""
    typer.echo(f"results go into {folder}", err=True)
    try:
        yield
    except _Stopped as stopped:
        stopped.add_note("the same command goes on where it stopped")
        stopped.add_note(f"what is there: frictionbench report {folder}")
        raise


_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


def main() -> Any:
    """The entry point: run the command line, errors of the user's as one line."""
    for number in _SIGNALS:
        signal.signal(number, _stop)
    try:
        app()
    except (ValueError, OSError) as error:
        from frictionbench.problems import InputError
        from frictionbench.results.store import ResultsError

        if not isinstance(error, InputError | ResultsError | OSError):
            raise
        typer.echo(f"frictionbench: {_told(error)}", err=True)
        sys.exit(2)
    except _Stopped as stopped:
        number = stopped.args[0]
        told = [f"broken off by {signal.Signals(number).name}", *getattr(stopped, "__notes__", ["nothing was kept"])]
        with suppress(OSError):  # the terminal may be gone
            typer.echo(f"\nfrictionbench: {'; '.join(told)}", err=True)
        sys.exit(128 + number)


def _told(error: Exception) -> str:
    """The error in our words: a file's name with what the system says of it."""
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"
    return str(error)
