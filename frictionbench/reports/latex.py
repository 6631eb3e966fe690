"""Conversion of text and tables to LaTeX: no name is interpreted as a command, and a table fits the width of the page. The
references of solvers are from references.bib in this folder, in which keywords name the solvers of each entry.
"""

import re
import unicodedata
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.font_manager import findfont, get_font

LARGEST, LEAST = 9.0, 6.5  # points, font sizes of a table; one that would be smaller takes the width of the page
BETWEEN = 0.8  # ems between columns
_DESIGNED = (5.0, 6.0, 7.0, 8.0, 9.0, 10.0)  # points, the design sizes of Computer Modern
_WIDER = (1.361, 1.222, 1.139, 1.063, 1.028, 1.0)  # the relative width of their letters, in ems of the last
_SPECIAL = str.maketrans({
    **{sign: "\\" + sign for sign in "&%$#_{}"},
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}",
    ">": r"\textgreater{}", "|": r"\textbar{}", '"': "''", "`": "'",
    "[": "{[}", "]": "{]}", "µ": r"\textmu{}", "μ": r"\textmu{}", "–": "--", "−": r"\ensuremath{-}",
    "×": r"\ensuremath{\times}", "≤": r"\ensuremath{\leq}",
})  # fmt: skip
ALWAYS = "all"


@dataclass(frozen=True)
class Layout:
    """The page for figures and tables.

    column: width of a column of text, inches; page: width of two columns with the gap, inches. font: serif or sans.
    """

    column: float = 3.35
    font: str = "serif"

    gap = 0.3  # inches

    @property
    def page(self) -> float:
        return 2 * self.column + self.gap


class Table(NamedTuple):
    """A tabular, and whether it takes the width of the page."""

    text: str
    wide: bool


class Tex(NamedTuple):
    """A cell given as LaTeX, and text of about the same width as its printed form."""

    code: str
    printed: str


Cell = str | Tex


def escaped(text: str) -> str:
    """The text with LaTeX's special characters escaped, in ASCII, which every font has."""
    plain = "".join(c if c.isprintable() else "?" for c in text).translate(_SPECIAL)
    if plain.isascii():
        return plain
    letters = (c for c in unicodedata.normalize("NFKD", plain) if not unicodedata.combining(c))
    return "".join(letters).encode("ascii", "replace").decode()


def one_unit(times: Sequence[float]) -> tuple[str, list[str]]:
    """A unit suitable for the times, s, and the times in this unit with three digits."""
    known = [time for time in times if np.isfinite(time) and time > 0]
    middle = float(np.exp(np.mean(np.log(known)))) if known else 1.0
    scale, unit = next(((s, u) for s, u in ((1.0, "s"), (1e-3, "ms")) if middle >= s), (1e-6, "µs"))
    return unit, [_digits(time / scale) if np.isfinite(time) else "–" for time in times]


def _digits(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 99.5 else f"{value:#.3g}".rstrip(".")


def booktabs(
    header: Sequence[str], body: Sequence[Sequence[Cell]], layout: Layout, groups: Sequence[tuple[str, int]] = ()
) -> Table:
    """A tabular with the first column aligned left and the others right.

    groups: a line above the header, given as texts with the number of columns that each spans.
    """
    ems = sum(max(_ems(row[i], layout.font) for row in (header, *body)) for i in range(len(header)))
    ems += BETWEEN * (len(header) - 1)
    wide = _size(ems, layout.column) < LEAST
    size = _size(ems, layout.page if wide else layout.column)
    lines = [
        " & ".join(cell.code if isinstance(cell, Tex) else escaped(cell) for cell in row) + r" \\" for row in (header, *body)
    ]
    over = [rf"\multicolumn{{{span}}}{{c}}{{{escaped(text)}}}" for text, span in groups]
    head = [" & ".join(over) + r" \\", *_rules(groups)] if groups else []
    return Table(
        "\n".join([
            f"% {'both columns, table*' if wide else 'one column, table'}",
            rf"{{\fontsize{{{size:.1f}}}{{{1.2 * size:.1f}}}\selectfont\setlength{{\tabcolsep}}{{{BETWEEN / 2}em}}%",
            rf"\begin{{tabular}}{{@{{}}l{'r' * (len(header) - 1)}@{{}}}}",
            *(r"\toprule", *head, lines[0], r"\midrule", *lines[1:], r"\bottomrule", r"\end{tabular}}", ""),
        ]),
        wide,
    )  # fmt: skip


def _rules(groups: Sequence[tuple[str, int]]) -> list[str]:
    first, rules = 1, []
    for text, span in groups:
        if text:
            rules.append(rf"\cmidrule(lr){{{first}-{first + span - 1}}}")
        first += span
    return ["".join(rules)] if rules else []


def _size(ems: float, inches: float) -> float:
    """The largest font size, points, at which a line of so many ems fits; small fonts have relatively wider letters."""
    sizes = np.arange(3.0, LARGEST + 0.05, 0.1)
    drawn = sizes * np.interp(sizes, _DESIGNED, _WIDER)
    fitting = sizes[ems * drawn <= 72.27 * inches]
    return float(fitting[-1]) if len(fitting) else 3.0


@cache
def _ems(cell: Cell, font: str) -> float:
    """The width of a text in Computer Modern, in ems, with a margin of 2 %."""
    text = cell.printed if isinstance(cell, Tex) else cell
    face = get_font(findfont("cmr10" if font == "serif" else "cmss10"))
    face.set_size(100.0, 72)
    face.set_text(re.sub(r"[^A-Za-z0-9 .,]", "0", text), 0.0)  # symbols that it may lack are at most as wide as a digit
    return 1.02 * face.get_width_height()[0] / 64 / 100


class Reference(NamedTuple):
    """An entry of the bibliography: its key, the solvers that it belongs to, and its text."""

    key: str
    solvers: frozenset[str]
    text: str


@cache
def references() -> tuple[Reference, ...]:
    """All references, in the order of the file."""
    text = Path(__file__).with_name("references.bib").read_text(encoding="utf-8")
    found = []
    for entry in re.findall(r"^@\w+\{.*?^\}\n", text, flags=re.MULTILINE | re.DOTALL):
        key, named = re.match(r"@\w+\{([^,]+),", entry), re.search(r"keywords = \{(.*?)\}", entry)
        assert key is not None, entry
        assert named is not None, entry
        found.append(Reference(key[1], frozenset(named[1].split(", ")), entry))
    return tuple(found)


def cited(solver: str) -> list[str]:
    """The keys of a solver's references; none for a plug-in."""
    return [entry.key for entry in references() if solver in entry.solvers]


def bibliography(solvers: Collection[str]) -> str:
    """The entries of these solvers, and those with the keyword ALWAYS."""
    return "\n".join(entry.text for entry in references() if entry.solvers & {ALWAYS, *solvers})
