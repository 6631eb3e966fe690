"""Text as LaTeX, in which no name is interpreted as a command, and the references of solvers from references.bib in this
folder, where the keywords of an entry name its solvers.
"""

import re
import unicodedata
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import NamedTuple

_SPECIAL = str.maketrans({
    **{sign: "\\" + sign for sign in "&%#_{}"}, "$": r"\ensuremath{\$}",
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}",
    ">": r"\textgreater{}", "|": r"\textbar{}", '"': "''", "`": "'",
    "[": "{[}", "]": "{]}", "µ": r"\ensuremath{\mu}", "μ": r"\ensuremath{\mu}", "–": "--", "−": r"\ensuremath{-}",
    "×": r"\ensuremath{\times}", "≤": r"\ensuremath{\leq}",
})  # fmt: skip
_POWER = re.compile(r"(?<![\w=.:])(\d(?:\.\d)?)e(-?\d{1,2})\b")  # 1e-8, 3e-2, but not in settings[tol=1e-8]
_COMMANDS = "|".join(re.escape(text) for text in _SPECIAL.values() if text[0] in "\\{")
_COMMANDS += r"|\\ensuremath\{(?:[\d.]+\\cdot )?10\^\{-?\d+\}\}"
ESCAPED = rf"(?:[^\\{{}}$&#^_~%\n]|{_COMMANDS})*"  # matches every result of `escaped`, but no text with other commands
ALWAYS = "all"


def escaped(text: str) -> str:
    """Return the text with LaTeX's special characters escaped and powers of ten typeset, in ASCII, which every font has."""
    plain = "".join(c if c.isprintable() else "?" for c in text).translate(_SPECIAL)
    plain = _POWER.sub(r"\\ensuremath{\1\\cdot 10^{\2}}", plain).replace(r"{1\cdot ", "{")
    if plain.isascii():
        return plain
    letters = (c for c in unicodedata.normalize("NFKD", plain) if not unicodedata.combining(c))
    return "".join(letters).encode("ascii", "replace").decode()


class Reference(NamedTuple):
    """An entry of the bibliography: its key, its solvers and its text."""

    key: str
    solvers: frozenset[str]
    text: str


@cache
def references() -> tuple[Reference, ...]:
    """All references, in the order of the file."""
    text = Path(__file__).with_name("references.bib").read_text(encoding="utf-8")
    entries = re.finditer(r"^@\w+\{([^,]+),.*?keywords = \{(.*?)\}\n\}\n", text, flags=re.MULTILINE | re.DOTALL)
    return tuple(Reference(entry[1], frozenset(entry[2].split(", ")), entry[0]) for entry in entries)


def cited(solver: str) -> list[str]:
    """The keys of a solver's references; none for a plug-in."""
    return [entry.key for entry in references() if solver in entry.solvers]


def bibliography(solvers: Collection[str], revision: str) -> str:
    """Return the entries of these solvers, and those with the keyword ALWAYS. revision: a note in the entry of this package."""
    entries = "\n".join(entry.text for entry in references() if entry.solvers & {ALWAYS, *solvers})
    note = escaped(re.sub(r"[^\w.+ -]", "?", revision))  # without braces, which BibTeX counts
    return entries.replace("REVISION", note)
