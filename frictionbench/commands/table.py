"""Tables and paragraphs as text: of full width in a pipe or file, no wider than the screen on a terminal."""

import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence

WIDEST = 110  # characters of a line of a paragraph: longer ones are hard to read


def screen() -> int | None:
    """The terminal's width in characters; None where the output is not a terminal."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def columns(header: Sequence[str], rows: Sequence[Sequence[str]], width: int | None, spare: Iterable[str] = ()) -> list[str]:
    """The lines of a table; empty columns are left out.

    spare: the names of columns to leave out as well, in this order, while the table is wider than the width; a line says so.
    """
    widths = {
        i: max(map(len, (name, *(row[i] for row in rows)))) for i, name in enumerate(header) if any(row[i] for row in rows)
    }
    cut = []
    for name in spare:
        if width is not None and sum(widths.values()) + 2 * (len(widths) - 1) > width:
            cut += [name] if widths.pop(list(header).index(name), None) else []
    told = (
        paragraph(f"not shown on {width} columns: {', '.join(cut)}; a wider terminal or a file has all", width, "")
        if cut
        else []
    )
    lines = ["  ".join(line[i].ljust(column_width) for i, column_width in widths.items()).rstrip() for line in (header, *rows)]
    return [*lines, *told]


def paragraph(text: str, width: int | None, indent: str = "    ") -> list[str]:
    """The text's lines, indented; one line where no width is given."""
    limit = 10**6 if width is None else min(max(width, 40), WIDEST)
    return textwrap.wrap(
        text, limit, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False, break_long_words=False
    )
