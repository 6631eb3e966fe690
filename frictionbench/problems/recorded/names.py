"""The names of a file's arrays, which errors use.

An array of a name that no reader knows is refused, since what it holds would be left out of the problem.
"""

import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from difflib import get_close_matches

from frictionbench.problems.check import InputError

ANSWERS = re.compile(r"[ru](_\w+)?")  # impulses and velocities that somebody found: not part of a problem
OTHERS = {"J": "F", "G": "F", "joint": "F", "velocity": "v"}  # names that are used elsewhere


def require_known(names: Collection[str], known: Collection[str], letters: dict[str, str] | None = None) -> None:
    """Check that all names are known or those of answers.

    letters: of fields, which may have been meant. Errors: InputError naming the first array that is neither, with the known
    name that it is most like and all that are known.
    """
    for name in names:
        if name not in known and not ANSWERS.fullmatch(name):
            meant = _most_like(name, known, letters or {})
            hint = f"; did you mean {meant}? Known" if meant else "; known"
            raise InputError(f"{name}: unknown array{hint} are {', '.join(sorted(known, key=str.lower))}")


@contextmanager
def in_letters(letters: dict[str, str]) -> Iterator[None]:
    """Errors within name the array that was given in place of the field that it was read as."""
    try:
        yield
    except InputError as error:
        field, _, reason = str(error).partition(": ")
        raise InputError(f"{letters.get(field, field)}: {reason}") from None


def _most_like(name: str, known: Collection[str], letters: dict[str, str]) -> str:
    """The known name that is most like this one, "" if none is."""
    by_name = {**letters, **OTHERS, **{one: one for one in known}}
    by_name = {other.lower(): one for other, one in by_name.items() if one in known}
    close = get_close_matches(name.lower(), by_name, n=1, cutoff=0.75)
    return by_name[close[0]] if close else ""
