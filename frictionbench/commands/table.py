"""Tables and paragraphs as text: full width in a pipe or file, no wider than the screen on a terminal."""

import re
import shutil
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence

from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

from frictionbench.results.files import cleaned

WIDEST = 110  # characters in a line of a paragraph: longer lines are hard to read


def screen() -> int | None:
    """Return the terminal's width in characters; None if the output is not a terminal."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def columns(header: Sequence[str], rows: Sequence[Sequence[str]], spare: Iterable[str] = ()) -> list[str]:
    """Return the lines of a table without empty columns.

    spare: names of columns to leave out, in this order, while the table is wider than the screen; a line says so. If that does
    not suffice, the longest cells are continued on further lines, names of solvers after [, a comma or _.
    """
    width = screen()
    widths = {
        i: max(map(len, (name, *(row[i] for row in rows)))) for i, name in enumerate(header) if any(row[i] for row in rows)
    }
    cut = []
    for name in spare:
        if not _fits(widths, width):
            cut += [name] if widths.pop(list(header).index(name), None) else []
    most = next((each for each in range(width or 10**4, 8, -1) if _fits(widths, width, each)), 8)
    cells = _Cells(most, break_on_hyphens=False)
    table = Table(*(Column(header[i], overflow="fold") for i in widths), box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for row in rows:
        table.add_row(*(Text(cells.fill(row[i])) for i in widths))
    wide = Console(width=width or 10**4, no_color=True)
    lines = ["".join(part.text for part in line).rstrip() for line in (wide.render_lines(table, pad=False) if rows else [])]
    left_out = f"not shown on {width} columns: {', '.join(cut)}; a wider terminal or a file has all"
    return [*lines, *(paragraph(left_out) if cut else [])]


class _Cells(textwrap.TextWrapper):
    wordsep_simple_re = re.compile(r"( +)|(?<=[\[,_])")


def _fits(widths: Mapping[int, int], width: int | None, most: int = 10**4) -> bool:
    """Return whether a table with these columns, each at most so wide, is no wider than the screen."""
    return width is None or sum(min(each, most) for each in widths.values()) + 2 * len(widths) - 2 <= width


def say(text: str, indent: str = "", rest: str = "") -> None:
    """Print a text, `cleaned`, as a paragraph."""
    print("\n".join(paragraph(str(cleaned(text)), indent, rest)), flush=True)


def paragraph(text: str, indent: str = "", rest: str = "") -> list[str]:
    """Return the text's lines, indented, and by rest after the first; one line if the output is not a terminal."""
    width = screen()
    limit = 10**6 if width is None else min(max(width, 40), WIDEST)
    return textwrap.wrap(
        text, limit, initial_indent=indent, subsequent_indent=indent + rest, break_on_hyphens=False, break_long_words=False
    )
