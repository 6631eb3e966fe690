"""Texts of others as they may be shown: names, reasons and messages can hold characters that a terminal would obey."""


def printable(text: str) -> str:
    """The text in one line without control characters."""
    return "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))
