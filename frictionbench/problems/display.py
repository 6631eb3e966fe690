"""One-line representations of problems and scenes, and small HTML tables for notebooks."""

from html import escape

from frictionbench.problems.rows import Array


def count(number: int, noun: str) -> str:
    """The number with its noun: 1 contact, 12 contacts, 3 bodies."""
    plural = noun[:-1] + "ies" if noun.endswith("y") else noun + "s"
    return f"{number} {noun if number == 1 else plural}"


def extent(values: Array) -> str:
    """The least and the largest value: "0.5", "0.2 to 0.9", or "" without values."""
    ends = dict.fromkeys(f"{end:g}" for end in (values.min(), values.max())) if values.size else {}
    return " to ".join(ends)


def html_table(title: str, rows: dict[str, object]) -> str:
    """A title and a table of names and values in HTML."""
    body = "".join(f"<tr><th>{escape(name)}</th><td>{escape(str(value))}</td></tr>" for name, value in rows.items())
    return f"<table><caption>{escape(title)}</caption>{body}</table>"
