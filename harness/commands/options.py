"""What the commands take: each option's name for its value, its help, and what is said of a value that cannot be used."""

import re
from collections.abc import Callable
from math import inf, nan
from pathlib import Path
from typing import Annotated, Any

import typer


def whole(least: int = 1) -> Callable[[Any], int]:
    """A reader of whole numbers from `least` on."""

    def read(text: Any) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise typer.BadParameter(f"takes a whole number from {least} on, not {str(text)!r}")
        return value

    return read


def number(least: float = -inf, most: float = inf) -> Callable[[Any], float]:
    """A reader of numbers from `least` to `most`."""
    bounds = f" between {least:g} and {most:g}" if most < inf else f" from {least:g} on" if least > -inf else ""

    def read(text: Any) -> float:
        try:
            value = float(text)
        except ValueError:
            value = nan
        if not least <= value <= most:
            raise typer.BadParameter(f"takes a number{bounds}, not {str(text)!r}")
        return value

    return read


def one_of(*known: str) -> Callable[[str], str]:
    """A reader of words from a list."""

    def read(text: str) -> str:
        if text not in known:
            raise typer.BadParameter(f"takes {', '.join(known[:-1])} or {known[-1]}, not {text!r}")
        return text

    return read


def length(text: Any) -> float:
    """A reader of lengths with a unit, in inches."""
    match = re.fullmatch(r"\s*([\d.]+)\s*(in|cm|mm|pt)?\s*", str(text))
    value = number()(match[1]) / INCH[match[2] or "in"] if match else 0.0
    if not 1 <= value <= 20:
        raise typer.BadParameter(f"takes a length from 1 to 20 inches, like 85mm, 3.35in or 241pt, not {str(text)!r}")
    return value


def listed(text: str) -> list[str]:
    """Names separated by commas, of which those in brackets separate settings."""
    return [name.strip() for name in re.split(r",(?![^\[]*\])", text) if name.strip()]


INCH = {"in": 1.0, "cm": 2.54, "mm": 25.4, "pt": 72.27}
Listing = Annotated[
    str, typer.Argument(metavar="scenes|solvers|suites", parser=one_of("scenes", "solvers", "suites"), help="What to list.")
]
Suite = Annotated[str, typer.Argument(metavar="SUITE", help="smoke, standard, ...: see `frictionbench list suites`.")]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A results folder.")]
Row = Annotated[str, typer.Argument(metavar="ROW", help="The row's key, as tables and reports give it, or how it begins.")]
Scenes = Annotated[
    list[str] | None,
    typer.Option("--scene", metavar="SCENE", help="Only this scene, like stack or 'stack[blocks=5]'; repeat for more."),
]
Solvers = Annotated[
    list[str] | None,
    typer.Option(
        "--solver",
        metavar="SOLVER",
        help="Only this solver, like 'nsgs[relaxation=1.3]', a file that defines some, or an installed one; repeat for more.",
    ),
]
Trusted = Annotated[
    list[str] | None,
    typer.Option("--solver", metavar="FILE|NAME", help="Solvers to trust; what a results folder names is not run."),
]
Tolerances = Annotated[str | None, typer.Option("--tol", metavar="T,T,...", help="Residuals to ask for, like 1e-4,1e-6,1e-8.")]
Tolerance = Annotated[float, typer.Option("--tol", metavar="T", parser=number(), help="Residual to ask for.")]
LIMIT = "Seconds for form, setup and solve together, enforced."
Limit = Annotated[float, typer.Option("--time-limit", metavar="S", parser=number(), help=LIMIT)]
SuitesLimit = Annotated[float | None, typer.Option("--time-limit", metavar="S", parser=number(), help=LIMIT)]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", metavar="N", parser=whole(), help="Worker processes, one core each; all cores by default."),
]
Data = Annotated[
    list[str] | None, typer.Option("--data", metavar="DIR|fclib/FAMILY", help="Recorded problems to run; repeat for more.")
]
Cluster = Annotated[
    str | None,
    typer.Option("--cluster", metavar="ADDRESS", help="Run the cells on this dask scheduler, like tcp://127.0.0.1:8786."),
]
Scheme = Annotated[str, typer.Option("--scheme", metavar="SCHEME", help="How time is stepped.")]
