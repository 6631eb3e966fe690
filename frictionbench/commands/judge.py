"""`frictionbench judge`: the judgement on an engine's steps in a few lines. The page shows percentiles and the worst steps."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from frictionbench.commands.table import columns, paragraph
from frictionbench.reports.drawing.text import residual, rough_percent, seconds
from frictionbench.reports.judged import read_judged
from frictionbench.results.conventions import count
from frictionbench.results.files import printable

SENTENCES = ("doubts", "creep", "forces", "impossible")  # properties of Judged


def as_data(folder: Path) -> dict[str, Any]:
    """Return the judgement as plain values for JSON: the page's sentences and tables, and every step."""
    judged = read_judged(folder)
    values = {name: getattr(judged, name) for name in (*SENTENCES, "laws", "notes", "percentiles", "beside")}
    return {"folder": str(folder), **values, "steps": [one.as_data() for one in judged.steps]}


def summary(folder: Path) -> str:
    """Return the summary of a judged folder: laws, notes, the worst step, and a table of the engine and the solvers."""
    judged = read_judged(folder)
    touching, beside = len(judged.touching), judged.beside
    without, idle = len(judged.steps) - touching, touching - min((other["steps"] for other in beside), default=touching)
    scene = printable(str(judged.rows["scene"].iloc[0]))
    lines = [f"{scene}: {count(touching, 'step')} with contacts judged by Coulomb's law, {without} without contact"]
    lines += [f"left out of the solvers' rows, as no impulse is needed: {count(idle, 'step')}"] if idle else []
    for answer in filter(None, (getattr(judged, name) for name in SENTENCES)):
        lines += paragraph(printable(answer))
    lines.append(f"law violated most: {', '.join(f'{law} in {steps}' for law, steps in judged.laws.items())}")
    for one in judged.worst(1):
        lines += [f"worst step: {printable(one.file)}, residual {residual(one.residual, 1)}, {one.law}"]
    if noted := judged.notes:
        means = "; ".join(f"{printable(name)} {rough_percent(mean)} in {count(n, 'step')}" for name, (mean, n) in noted.items())
        lines += paragraph(f"not expressed by the problems, with mean shares of the impulse: {means}")
    header = ("", "solved", "residual p50", "residual worst", "time p50", "time p99", "time worst")
    digits = partial(residual, decimals=1)
    engine = _shown(judged.percentiles["residual"], ("p50", "worst"), digits)
    body: list[tuple[str, ...]] = [("the engine", "", *engine, "", "", "")]
    for other in beside:
        residuals = _shown(other["residual"], ("p50", "worst"), digits)
        times = _shown(other["time"], ("p50", "p99", "worst"), seconds)
        body.append((other["variant"], f"{other['solved']}/{other['steps']}", *residuals, *times))
    return "\n".join([*lines, "", *columns(header, body, ("time p99", "residual p50"))])


def _shown(values: dict[str, float] | None, which: tuple[str, ...], form: Callable[[float], str]) -> list[str]:
    """Return some of the percentiles as text; empty texts without percentiles."""
    return [form(values[name]) if values else "" for name in which]
