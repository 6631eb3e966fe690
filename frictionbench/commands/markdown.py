"""A table of the terminal in Markdown, for the documents."""

from rich.table import Table
from rich.text import Text


def markdown_table(table: Table) -> str:
    """The heads and rows of a table of texts."""
    columns = [[str(column.header), *(Text.from_markup(str(cell)).plain for cell in column.cells)] for column in table.columns]
    heads, *rows = zip(*columns, strict=True)
    return "\n".join(f"| {' | '.join(row)} |" for row in [heads, ["---"] * len(heads), *rows])
