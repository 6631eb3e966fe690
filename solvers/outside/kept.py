"""A library's own object, kept from one problem for the next, as a simulator would over a sequence of steps."""

from collections.abc import Callable
from typing import Any


class Kept:
    """The object of the problem before, and the pattern it was made for (ScaledProgram.pattern)."""

    def __init__(self) -> None:
        self._pattern: tuple[bytes, ...] | None = None
        self._made: Any = None

    def take(self, pattern: tuple[bytes, ...], make: Callable[[], Any], update: Callable[[Any], None]) -> Any:
        """The object kept, updated, where the pattern is the same; otherwise another, kept in its place."""
        if pattern == self._pattern:
            update(self._made)
        else:
            self._made = make()
            self._pattern = pattern
        return self._made
