"""The command line. Exit codes: 0 done, 1 a regression (compare), 2 unusable input, 128 + n ended by signal n.

Everything heavy is imported inside the command that needs it, so that --help answers at once.
"""

import signal
import sys
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

app = typer.Typer(
    help="Compare solvers for the friction LCPs of rigid-body dynamics.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

Suite = Annotated[str, typer.Argument(help="smoke, standard, ...: see `frictionbench list suites`.")]
Scenes = Annotated[
    list[str] | None,
    typer.Option("--scene", metavar="SCENE", help="Only this scene, like `stack` or `stack[blocks=5]`; repeat for more."),
]
Solvers = Annotated[
    list[str] | None,
    typer.Option(
        "--solver",
        metavar="SOLVER",
        help="Only this solver, like `nsgs[relaxation=1.3]`, a file that defines some, or an installed one; repeat for more.",
    ),
]
Files = Annotated[
    list[str] | None,
    typer.Option("--solver", metavar="FILE|NAME", help="Solvers to trust; what a results folder names is not run."),
]
Tolerances = Annotated[str | None, typer.Option("--tol", metavar="T,T,...", help="Residuals to ask for, like 1e-4,1e-6,1e-8.")]
Limit = Annotated[
    float | None, typer.Option("--time-limit", metavar="S", help="Seconds for form, setup and solve together, enforced.")
]
Jobs = Annotated[int | None, typer.Option("--jobs", min=1, help="Worker processes, one core each; all cores by default.")]


class Listing(StrEnum):
    """What `list` can list."""

    SCENES = "scenes"
    SOLVERS = "solvers"
    SUITES = "suites"


@app.command("list")
def list_(what: Annotated[Listing, typer.Argument()]) -> None:
    """List the scenes, the solvers or the suites, a line of meaning each."""
    from harness.commands import listing

    listing.show(what.value)


@app.command()
def run(
    suite: Suite = "standard",
    scene: Scenes = None,
    solver: Solvers = None,
    tol: Tolerances = None,
    time_limit: Limit = None,
    jobs: Jobs = None,
    data: Annotated[
        list[str] | None,
        typer.Option("--data", metavar="DIR|fclib/FAMILY", help="Recorded problems to run; repeat for more."),
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option("--cluster", metavar="ADDRESS", help="Run the cells on this dask scheduler, like tcp://127.0.0.1:8786."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="DIR", help="Results folder; runs/SUITE by default. A broken-off run goes on where it stopped."
        ),
    ] = None,
) -> None:
    """Run a suite, or what of it the options choose. The same command resumes a broken-off run."""
    from harness.maps import run_maps
    from harness.plans.choose import choose
    from harness.progress import Progress
    from harness.workers.introduce import introduce

    variants, plugins = introduce(solver or [])
    plan = choose(suite, scene or [], variants, tol, time_limit, plugins, tuple(data or ()))
    folder = out or Path("runs") / suite
    run_maps(plan, folder, _jobs(jobs), Progress(), cluster)
    typer.echo(f"results: {folder}\nreport:  frictionbench report {folder}")


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR")],
    paper: Annotated[bool, typer.Option("--paper", help="Also write vector figures and LaTeX tables for a paper.")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="Also write the run's figures as Markdown.")] = False,
) -> None:
    """Make the HTML report of a results folder."""
    from reports.page import write_report

    typer.echo(f"report: {write_report(folder)}")
    if paper:
        from reports.paper import write_paper

        typer.echo(f"paper:  {write_paper(folder)}")
    if markdown:
        from reports.markdown import write_markdown

        typer.echo(f"figures: {write_markdown(folder)}")


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
    solver: Files = None,
    slowdown: Annotated[float, typer.Option("--slowdown", min=1, help="Ratio of times up to which nothing is slower.")] = 1.1,
    growth: Annotated[float, typer.Option("--growth", min=1, help="Ratio of work up to which nothing has grown.")] = 1.05,
    alpha: Annotated[float, typer.Option("--alpha", min=0, max=1, help="Chance of error of the times' intervals.")] = 0.05,
    no_times: Annotated[bool, typer.Option("--no-times", help="Leave times out.")] = False,
    known: Annotated[
        Path | None, typer.Option("--known", metavar="FILE", help="Acknowledged changes with their reasons, in TOML.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FOLDER", help="Write it as Markdown, JSON, benchmark JSON and JUnit XML.")
    ] = None,
) -> None:
    """Compare two runs as Markdown; exit 0 nothing worse, 1 a regression, 2 unusable input."""
    from reports.comparison.files import write_files
    from reports.comparison.markdown import markdown, summarise
    from results.compare import Limits
    from results.compare import compare as compare_runs
    from results.known import acknowledge, read

    acknowledged = read(known) if known else []
    limits = Limits(slowdown, growth, alpha, not no_times)
    comparison = compare_runs(baseline, folder, limits)
    if confirm:
        from harness.commands.confirm import confirmed

        comparison = confirmed(comparison, limits, solver or [], code, lambda line: typer.echo(line, err=True))
    comparison = acknowledge(comparison, acknowledged)
    typer.echo(markdown(comparison))
    summarise(comparison)
    if out:
        write_files(comparison, out)
    raise typer.Exit(comparison.exit_code)


@app.command()
def accept(
    folder: Annotated[Path, typer.Argument(metavar="DIR")],
    baseline: Annotated[
        Path | None, typer.Argument(metavar="BASELINE", help="The text to write; baselines/SUITE.tsv by default.")
    ] = None,
) -> None:
    """Make a run the baseline that others are compared with, and show what that changes."""
    from harness.commands.accept import accept as accept_run
    from reports.comparison.markdown import markdown

    before, told = accept_run(folder, baseline)
    if before is not None:
        typer.echo(markdown(before))
    typer.echo(told)


@app.command()
def history(folders: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Results folders and baselines.")]) -> None:
    """Show verdicts, work and times of runs over time."""
    from rich.console import Console

    from reports.comparison.history import history as table_of

    console = Console()
    (console if console.is_terminal else Console(width=160)).print(table_of(folders))


@app.command()
def solve(
    problem: Annotated[str, typer.Argument(metavar="FILE|SCENE", help="A problem file, or a scene like `stack[blocks=5]`.")],
    solver: Solvers = None,
    tol: Annotated[float, typer.Option("--tol")] = 1e-8,
    time_limit: Annotated[float, typer.Option("--time-limit", metavar="S")] = 10.0,
    jobs: Jobs = None,
) -> None:
    """Put every solver to one problem and show a table."""
    from harness.commands.single import solve_one

    solve_one(problem, solver or [], tol, time_limit, _jobs(jobs))


@app.command()
def export(
    problems: Annotated[str, typer.Argument(metavar="SCENE|DIR", help="A scene, or a results folder.")],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FILE.hdf5|FOLDER", help="One file, or a folder where there are several.")
    ],
    pick: Annotated[
        int, typer.Option("--pick", min=0, help="Problems spread over the scene's motion; 0: the first alone.")
    ] = 0,
) -> None:
    """Write problems in FCLIB's HDF5 format, for others to solve."""
    from harness.commands.export import export as export_problems

    for path in export_problems(problems, out, pick):
        typer.echo(path)


@app.command()
def fetch(
    family: Annotated[str, typer.Argument(metavar="fclib/FAMILY", help="Like fclib/Capsules; `fclib/` lists those known.")],
) -> None:
    """Download recorded problems of FCLIB's public collection, checked by size and sha256, into the user's cache."""
    from harness.commands.fetch import fetch as fetch_family

    fetch_family(family)


@app.command()
def show(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="Like `stack` or `stack[blocks=5]`.")],
    solver: Annotated[str, typer.Option("--solver", metavar="SOLVER", help="A solver, or a file that defines one.")] = "lemke",
    scheme: Annotated[str, typer.Option("--scheme", metavar="SCHEME", help="How time is stepped.")] = "anitescu_potra",
    steps: Annotated[int | None, typer.Option("--steps", min=1, help="The scene's whole duration by default.")] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.html", help="SCENE.html by default.")] = None,
) -> None:
    """Animate a scene: one HTML page with its bodies, contact impulses, friction cones and energy."""
    from harness.cells.record import record_named
    from reports.animation import write_animation

    motion = record_named(scene, solver, scheme, steps)
    typer.echo(f"animation: {write_animation(motion, out or Path(f'{motion.scene}.html'))}")
    if motion.ended:
        typer.echo(f"it ends after {len(motion.times) - 1} steps: {motion.ended}", err=True)


@app.command("map")
def map_(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="Like `painleve_rod` or `stack[push=1]`.")],
    x: Annotated[str, typer.Option("--x", metavar="PARAMETER=FROM:TO:N", help="Like `friction=.1:3:30`.")],
    y: Annotated[str, typer.Option("--y", metavar="PARAMETER=FROM:TO:N", help="Like `mass_ratio=log:1e-6:1e6:13`.")],
    solver: Solvers = None,
    tol: Annotated[str, typer.Option("--tol", metavar="T", help="Residual to ask for.")] = "1e-6",
    time_limit: Annotated[float, typer.Option("--time-limit", metavar="S")] = 1.0,
    scheme: Annotated[str, typer.Option("--scheme", metavar="SCHEME", help="Whose problems.")] = "anitescu_potra",
    steps: Annotated[int, typer.Option("--steps", min=0, help="Steps in closed loop; 0 for the first problem alone.")] = 0,
    jobs: Jobs = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Results folder; goes on where it stopped.")] = None,
) -> None:
    """Draw a failure map: a scene over a grid of two of its parameters, with every solver, refined where verdicts differ."""
    from harness.commands.map import folder_of, plan_map
    from harness.maps import run_maps
    from harness.progress import Progress
    from harness.workers.introduce import introduce
    from reports.page import write_report

    variants, plugins = introduce(solver or [])
    plan = plan_map(scene, x, y, variants, plugins, tol, time_limit, scheme, steps)
    folder = out or folder_of(plan)
    run_maps(plan, folder, _jobs(jobs), Progress())
    typer.echo(f"report: {write_report(folder)}")


@app.command("check-solver")
def check_solver(
    solver: Annotated[
        list[str], typer.Argument(metavar="FILE|NAME...", help="A file that defines solvers, or names; all variants of a name.")
    ],
    jobs: Jobs = None,
) -> None:
    """Hold a solver to the contract: what is wrong with it, and what to do; exit 0 where it keeps all of it, else 1."""
    from harness.contract.examine import examine, told

    found = examine(solver, _jobs(jobs))
    typer.echo(told(found))
    raise typer.Exit(int(any(one.complaints for one in found)))


@app.command()
def rerun(
    folder: Annotated[Path, typer.Argument(metavar="DIR")],
    row: Annotated[str, typer.Argument(metavar="ROW", help="The row's key, as tables and reports give it.")],
    solver: Files = None,
) -> None:
    """Run one cell of a results folder again and show both rows."""
    from harness.commands.single import show_rerun

    show_rerun(folder, row, solver or [])


@app.command()
def shrink(
    folder: Annotated[Path, typer.Argument(metavar="DIR")],
    row: Annotated[str, typer.Argument(metavar="ROW", help="The key of a solve row that failed.")],
    solver: Files = None,
) -> None:
    """Make a failing cell's problem as small as it can be while it still fails, and keep it as a file."""
    from harness.commands.shrink import shrink as shrink_row

    path, problem, trials = shrink_row(folder, row, solver or [])
    typer.echo(f"{problem.contacts} contacts and {len(problem.free_velocity)} velocities left after {trials} trials: {path}")
    typer.echo(f"again: frictionbench solve {path}")


def _jobs(jobs: int | None) -> int:
    from harness.process import cores, require_linux
    from problems import InputError

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


_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


def main() -> Any:
    """The entry point: run the command line, errors of the user's as one line."""
    for number in _SIGNALS:
        signal.signal(number, _stop)
    try:
        app()
    except (ValueError, OSError) as error:
        from problems import InputError
        from results.store import ResultsError

        if not isinstance(error, InputError | ResultsError | OSError):
            raise
        typer.echo(f"frictionbench: {error}", err=True)
        sys.exit(2)
    except _Stopped as stopped:
        number = stopped.args[0]
        name = signal.Signals(number).name
        with suppress(OSError):  # the terminal may be gone
            typer.echo(f"frictionbench: broken off by {name}; the same command goes on where it stopped", err=True)
        sys.exit(128 + number)
