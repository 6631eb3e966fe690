"""Numbers in one-line representations of problems and scenes."""


def count(number: int, noun: str) -> str:
    """The number with its noun: 1 contact, 12 contacts, 3 bodies."""
    plural = noun[:-1] + "ies" if noun.endswith("y") else noun + "s"
    return f"{number} {noun if number == 1 else plural}"
