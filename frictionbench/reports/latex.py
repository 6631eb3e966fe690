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

LETTERS = 75  # of a row that a column of text takes at a readable size; a table of longer rows takes the width of the page
# Shrinks what is wider than the column; \width is graphicx's name for the natural width of the box.
FIT = r"\footnotesize\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"
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


def booktabs(header: Sequence[str], body: Sequence[Sequence[Cell]], groups: Sequence[tuple[str, int]] = ()) -> Table:
    """A tabular with the first column aligned left and the others right.

    Its document loads graphicx. groups: a line above the header, given as texts with the number of columns that each spans.
    """
    widths = [
        max(len(cell.printed if isinstance(cell, Tex) else cell) for cell in column)
        for column in zip(header, *body, strict=True)
    ]
    wide = sum(widths) + 2 * len(header) > LETTERS
    lines = [
        " & ".join(cell.code if isinstance(cell, Tex) else escaped(cell) for cell in row) + r" \\" for row in (header, *body)
    ]
    over = [rf"\multicolumn{{{span}}}{{c}}{{{escaped(text)}}}" for text, span in groups]
    head = [" & ".join(over) + r" \\", *_rules(groups)] if groups else []
    return Table(
        "\n".join([
            f"% {'both columns, table*' if wide else 'one column, table'}",
            rf"{{{FIT}",
            rf"\begin{{tabular}}{{@{{}}l{'r' * (len(header) - 1)}@{{}}}}",
            *(r"\toprule", *head, lines[0], r"\midrule", *lines[1:], r"\bottomrule", r"\end{tabular}}}", ""),
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
