"""The references of solvers, from references.bib beside this file, whose keywords name the solvers that an entry is for."""

import re
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import NamedTuple

ALWAYS = "all"


class Reference(NamedTuple):
    """An entry of the bibliography: its key, whom it is for, and its text."""

    key: str
    solvers: frozenset[str]
    text: str


@cache
def references() -> tuple[Reference, ...]:
    """All of them, in the file's order."""
    text = Path(__file__).with_name("references.bib").read_text(encoding="utf-8")
    found = []
    for entry in re.findall(r"^@\w+\{.*?^\}\n", text, flags=re.MULTILINE | re.DOTALL):
        key, named = re.match(r"@\w+\{([^,]+),", entry), re.search(r"keywords = \{(.*?)\}", entry)
        assert key is not None, entry
        assert named is not None, entry
        found.append(Reference(key[1], frozenset(named[1].split(", ")), entry))
    return tuple(found)


def cited(solver: str) -> list[str]:
    """The keys of a solver's references; none of one from outside."""
    return [entry.key for entry in references() if solver in entry.solvers]


def bibliography(solvers: Collection[str]) -> str:
    """The entries of these solvers, and those that every paper needs."""
    return "\n".join(entry.text for entry in references() if entry.solvers & {ALWAYS, *solvers})
