"""The format of names and numbers in figures, tables and pages."""

import numpy as np


def plain(text: str, longest: int = 48) -> str:
    """Text for a figure: cut to length, characters that the font or XML lacks replaced, and a leading underscore, which would
    hide a legend's item, preceded by a space."""
    latin = text.encode("latin-1", "replace").decode("latin-1")
    shown = "".join(c if c.isprintable() else "?" for c in latin)
    shown = shown if len(shown) <= longest else shown[: longest - 3] + "..."
    return " " + shown if shown.startswith("_") else shown


def seconds(value: float) -> str:
    """A time, s, in a suitable unit: 12 µs, 3.4 ms, 0.56 s."""
    if not np.isfinite(value):
        return "–"
    for scale, unit in ((1e-6, "µs"), (1e-3, "ms")):
        if abs(value) < 999.5 * scale:
            return f"{value / scale:.2g} {unit}" if abs(value) < 99.5 * scale else f"{value / scale:.0f} {unit}"
    return f"{value:.2g} s" if abs(value) < 99.5 else f"{value:.0f} s"


def power(value: float) -> str:
    """A power of ten: 1e-8."""
    return f"1e{round(np.log10(value))}" if value > 0 else "0"
