"""Arguments and options that several commands share, and parsers for options without a type in typer."""

import re
from pathlib import Path
from typing import Annotated, Literal

import typer

from frictionbench.results.conventions import RankBy


def parse_length(text: str) -> float:
    """Parse a length with a unit, by default inches, in inches. Errors: BadParameter if it is unreadable or out of range."""
    value = _quantity(text, UNITS_PER_INCH)
    if not 1 <= value <= 20:
        raise typer.BadParameter(f"{text!r} is not a length from 1 to 20 inches; write it like 85mm, 3.35in or 241pt")
    return value


def parse_duration(text: str) -> float:
    """Parse a time with a unit, in seconds. Errors: BadParameter if it is unreadable or not positive."""
    value = _quantity(text, UNITS_PER_SECOND)
    if not value > 0:
        raise typer.BadParameter(f"{text!r} is not a time with a unit; write it like 1ms, 250us or 0.5s")
    return value


def parse_folder(text: str) -> Path:
    """Return a folder's path. Errors: BadParameter for an option, such as -q, which would be taken as the name."""
    if text.startswith("-"):
        raise typer.BadParameter(f"{text!r} is no name of a folder: other commands would read it as an option")
    return Path(text)


def _quantity(text: str, units: dict[str, float]) -> float:
    """Parse a number with a unit, in the unit of which `units` gives the number per base unit; 0 if it is unreadable."""
    match = re.fullmatch(rf"\s*(\d+\.?\d*|\.\d+)\s*({'|'.join(units)})\s*", text)
    return float(match[1]) / units[match[2]] if match else 0.0


def split_names(text: str) -> list[str]:
    """Split names at commas, except for commas inside brackets and before a range of sizes (stack, n < 100)."""
    return [name.strip() for name in re.split(r",(?![^\[]*\]| n (?:<|from) )", text) if name.strip()]


UNITS_PER_SECOND = {"us": 1e6, "µs": 1e6, "μs": 1e6, "ms": 1e3, "s": 1.0}
UNITS_PER_INCH = {"in": 1.0, "": 1.0, "cm": 2.54, "mm": 25.4, "pt": 72.27}
Listing = Annotated[
    Literal["scenes", "solvers", "suites"], typer.Argument(metavar="scenes|solvers|suites", help="What to list.")
]
Suite = Annotated[str | None, typer.Argument(metavar="SUITE", help="See `frictionbench list suites`; by default standard.")]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A results folder.")]
Row = Annotated[str, typer.Argument(metavar="ROW", help="A row's key or its beginning; without it, failed rows are listed.")]
Scenes = Annotated[
    list[str] | None, typer.Option("--scene", metavar="SCENE", help="Only this scene, like 'stack[blocks=5]'; may be repeated.")
]
Solvers = Annotated[
    list[str] | None,
    typer.Option(
        "--solver",
        metavar="SOLVER",
        help="Only this solver, like 'nsgs[relaxation=1.3]', a file that defines solvers, 'exec:./program {problem} {answer}', "
        "or an installed plug-in; may be repeated.",
    ),
]
Trusted = Annotated[
    list[str] | None, typer.Option("--solver", metavar="FILE|NAME", help="A plug-in or exec: command that may run again.")
]
Tolerances = Annotated[
    str | None, typer.Option("--tol", metavar="T,T,...", help="Tolerances on the residual, like 1e-4,1e-6,1e-8.")
]
Tolerance = Annotated[float, typer.Option("--tol", metavar="T", help="Tolerance on the residual.")]
LIMIT_HELP = "Limit in seconds for form, setup and solve together, enforced."
Limit = Annotated[float, typer.Option("--time-limit", metavar="S", help=LIMIT_HELP)]
SuitesLimit = Annotated[float | None, typer.Option("--time-limit", metavar="S", help=LIMIT_HELP)]
Jobs = Annotated[
    int | None, typer.Option("--jobs", metavar="N", min=1, help="Workers, one core each; by default all cores but one.")
]
Data = Annotated[
    list[str] | None,
    typer.Option(
        "--data", metavar="DIR|FILE|fclib/FAMILY", help="Recorded problems, or a sequence for `run replay`; may be repeated."
    ),
]
Cluster = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="Run on this dask scheduler, like tcp://127.0.0.1:8786.")
]
Budget = Annotated[
    float | None,
    typer.Option("--budget", metavar="1ms|250us|0.5s", parser=parse_duration, help="Also show the share solved in this time."),
]
_BY = "Time by which solvers are ranked or compared: bodies (form, setup and solve) or form (setup and solve)."
By = Annotated[RankBy, typer.Option("--rank-by", help=_BY)]
ByOfProblem = Annotated[
    RankBy | None, typer.Option("--rank-by", help=f"{_BY} By default bodies, but form where a problem is given by its matrix.")
]
_OUT = "Results folder; by default one below runs/ for these settings."
Out = Annotated[Path | None, typer.Option("--out", metavar="DIR", parser=parse_folder, help=_OUT)]
Config = Annotated[
    Path | None, typer.Option("--config", metavar="FILE|DIR", help="Options from a TOML file or a run; those given prevail.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON in place of text.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show only results and errors, no progress.")]
Scheme = Annotated[str, typer.Option("--scheme", metavar="SCHEME", help="Time-stepping scheme.")]
