"""A library's object that is reused from one problem to the next, as a simulator would over a sequence of steps."""

from collections.abc import Callable
from typing import Any


class ReusedObject:
    """The object of the previous problem, and the sparsity pattern that it was made for (ScaledProgram.pattern)."""

    def __init__(self) -> None:
        self._pattern: tuple[bytes, ...] | None = None
        self._object: Any = None

    def get(self, pattern: tuple[bytes, ...], make: Callable[[], Any], update: Callable[[Any], None]) -> Any:
        """The stored object, updated, if the pattern is the same; otherwise a new one, which is stored instead."""
        if pattern == self._pattern:
            update(self._object)
        else:
            self._object = make()
            self._pattern = pattern
        return self._object
