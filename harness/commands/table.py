"""Tables and lists as text: as wide as they are where a program reads them, no wider than the terminal where a person does."""

import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence

WIDEST = 110  # characters of a paragraph


def screen() -> int | None:
    """The terminal's width in characters; None where the output is none."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def columns(header: Sequence[str], rows: Sequence[Sequence[str]], width: int | None, spare: Iterable[str] = ()) -> list[str]:
    """Lines with the columns side by side; those that hold nothing are left out.

    spare: the names of columns that may be left out too where the width does not hold all of them, the first to go first.
    """
    widths = {
        i: max(map(len, (name, *(row[i] for row in rows)))) for i, name in enumerate(header) if any(row[i] for row in rows)
    }
    for name in spare:
        if width is not None and sum(widths.values()) + 2 * (len(widths) - 1) > width:
            widths.pop(list(header).index(name), None)
    return ["  ".join(line[i].ljust(room) for i, room in widths.items()).rstrip() for line in (header, *rows)]


def paragraph(text: str, width: int | None, indent: str = "    ") -> list[str]:
    """The text's lines, indented; one line where no width is given."""
    room = 10**6 if width is None else min(max(width, 40), WIDEST)
    return textwrap.wrap(text, room, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False)
