"""`frictionbench judge`: the judgement on an engine's steps as text."""

from collections.abc import Callable
from pathlib import Path

from frictionbench.commands.table import columns, paragraph, screen
from frictionbench.results.files import printable
from frictionbench.results.judgement import (
    PERCENTILES,
    QUANTITIES,
    Judgement,
    beside,
    impossible,
    laws,
    notes,
    percentiles,
    read_judgements,
    touching,
    worst,
)
from frictionbench.results.store import read_table

MOST = 5  # steps listed as the worst


def told(folder: Path) -> str:
    """The summary of a judged folder: percentiles, laws, notes, the solvers beside, and the worst steps."""
    found, rows = read_judgements(folder), read_table(folder, "solves")
    counted = touching(found)
    lines = [f"{len(counted)} steps with contacts judged by Coulomb's law, {len(found) - len(counted)} without contact"]
    lines += _quantities(found)
    most = ", ".join(f"{law} in {count}" for law, count in laws(found).items())
    lines += ["", f"law violated most: {most}" if most else "no law is violated beyond rounding"]
    if proved := impossible(found):
        lines += paragraph(printable(proved), screen(), "")
    if noted := notes(found):
        means = "; ".join(f"{printable(name)} {100 * share:.2g} % in {count} steps" for name, (share, count) in noted.items())
        lines += paragraph(f"not expressed by the problems, with mean shares of the impulse: {means}", screen(), "")
    header = ("", "solved", *(f"residual {_name(p)}" for p in (50, 100)), *(f"time {_name(p)}" for p in (50, 99, 100)))
    engine = percentiles(found)["residual"]
    body: list[tuple[str, ...]] = [("the engine", "", *_shown(engine, (0, 3), _number), "", "", "")]
    for one in beside(rows):
        residuals, times = _shown(one.residual, (0, 3), _number), _shown(one.time, (0, 2, 3), _milliseconds)
        body.append((one.variant, f"{one.solved}/{one.problems}", *residuals, *times))
    return "\n".join([*lines, "", *columns(header, body, screen()), "", *_worst(found)])


def _quantities(found: list[Judgement]) -> list[str]:
    body = [
        (f"{name.replace('_', ' ')}{unit and f', {unit}'}", *map(_number, values))
        for (name, values), unit in zip(percentiles(found).items(), QUANTITIES.values(), strict=True)
        if values is not None
    ]
    return columns(("", *map(_name, PERCENTILES)), body, screen())


def _worst(found: list[Judgement]) -> list[str]:
    header = ("worst steps", "residual", "law", "m/s", "creep, m/s", "penetration, m", "contacts")
    body = [
        (
            printable(one.file),
            _number(one.residual),
            one.law,
            _number(getattr(one, one.law)),
            _number(one.creep),
            _number(one.penetration),
            str(one.contacts),
        )
        for one in worst(found, MOST)
    ]
    return columns(header, body, screen(), ("contacts", "penetration, m", "creep, m/s"))


def _shown(values: list[float] | None, which: tuple[int, ...], form: Callable[[float | None], str]) -> list[str]:
    """Some of the percentiles as text; nothing where there are none."""
    return [form(values[i] if values else None) for i in which]


def _name(percentile: int) -> str:
    return "worst" if percentile == 100 else f"p{percentile}"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.1e}"


def _milliseconds(value: float | None) -> str:
    return "" if value is None else f"{1e3 * value:.3g} ms"
