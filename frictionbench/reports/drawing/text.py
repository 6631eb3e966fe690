"""The format of names and numbers in figures, tables and pages."""

from collections.abc import Iterable, Sequence

import numpy as np

from frictionbench.results.files import printable


def plain(text: str, longest: int = 48) -> str:
    """Prepare text for a figure: cut it to length, replace characters that the font or XML lacks, and put a space before a
    leading underscore, with which matplotlib would hide a legend's entry."""
    shown = printable(text.encode("latin-1", "replace").decode("latin-1"))
    shown = shown if len(shown) <= longest else shown[: longest - 3] + "..."
    return " " + shown if shown.startswith("_") else shown


def code(text: str) -> str:
    """Return text as Markdown code that cannot leave its table cell."""
    return "`" + printable(text).replace("`", "'").replace("|", "\\|") + "`"


def escaped(text: str) -> str:
    """Escape the characters that begin tables, links and tags in Markdown."""
    return printable(text).replace("|", "\\|").replace("[", "\\[").replace("<", "&lt;")


def pipe(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table. header, rows: texts that are escaped already."""
    return [f"| {' | '.join(line)} |" for line in (header, ["---"] * len(header), *rows)]


def seconds(value: float, digits: int = 2) -> str:
    """Format a time, s, in a suitable unit: 12 µs, 3.4 ms, 1.2 s. digits: significant digits, without trailing zeros."""
    if not np.isfinite(value):
        return "–"
    units = ((1e-6, "µs"), (1e-3, "ms"))
    scale, unit = next((each for each in units if abs(value) < 999.5 * each[0]), (1.0, "s"))
    size = value / scale
    return f"{size:.{digits}g} {unit}" if abs(size) < 10**digits - 0.5 else f"{size:.0f} {unit}"


def percent(share: float, decimals: int = 0) -> str:
    """Format a share in percent, rounded: 37 %, 4.2 %. Only exact shares are shown as 0 % and 100 %."""
    steps = 100 * 10**decimals
    rounded = round(steps * share)
    if 1e-9 < share < 1 - 1e-9:
        rounded = min(max(rounded, 1), steps - 1)
    return f"{rounded / 10**decimals:g} %"


def rough_percent(share: float) -> str:
    """Return a share in percent with two digits, or as a whole number from 99.5 on."""
    if 0 < abs(share) < 1e-4:
        return "<0.01 %"
    return f"{100 * share:.{'2g' if abs(share) < 0.995 else '0f'}} %"


def ratio(value: float) -> str:
    """Format a ratio with three digits and trailing zeros: 1.00, 12.3."""
    return f"{value:#.3g}".rstrip(".")


def power(value: float) -> str:
    """Format a number as a power of ten: 1e-8."""
    return f"1e{round(np.log10(value))}" if value > 0 else "0"


def residual(value: float, decimals: int = 0) -> str:
    """Format a residual with one digit and `decimals` more: 3e-9; from 1 to 10 without an exponent."""
    if value == 0 or not np.isfinite(value):
        return f"{value:g}"
    digit, exponent = f"{value:.{decimals}e}".split("e")
    return f"{digit}e{int(exponent)}".removesuffix("e0")
