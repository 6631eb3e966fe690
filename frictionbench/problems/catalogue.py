"""Catalogues of what a name and a few parameters make, scenes and instances, and how modules register in them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from inspect import getdoc, signature
from pkgutil import iter_modules
from typing import Any, Generic, TypeVar

from frictionbench.problems.check import InputError

Made = TypeVar("Made")


@dataclass(frozen=True)
class Generator(Generic[Made]):
    """A function under its name in a catalogue, with its parameters' defaults and its docstring."""

    name: str
    make: Callable[..., Made]
    parameters: dict[str, Any]
    description: str

    @property
    def summary(self) -> str:
        """The first line of the description; python -OO leaves none."""
        return self.description.partition("\n")[0]


class Catalogue(Generic[Made]):
    """Generators by name. kind: what they make, in error messages."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._generators: dict[str, Generator[Made]] = {}

    def add(self, make: Callable[..., Made], name: str = "", **defaults: Any) -> None:
        """List a function, by default under its own name; defaults replace those of its signature.

        Errors: ValueError where the name is taken.
        """
        name = name or make.__name__
        if name in self._generators:
            raise ValueError(f"{self.kind}: the name {name!r} is taken by {self._generators[name].make}")
        own = {key: parameter.default for key, parameter in signature(make).parameters.items()}
        self._generators[name] = Generator(name, make, own | defaults, getdoc(make) or "")

    def generators(self) -> dict[str, Generator[Made]]:
        """All generators by name, in alphabetical order."""
        return dict(sorted(self._generators.items()))

    def find(self, name: str, parameters: Iterable[str]) -> Generator[Made]:
        """The generator of this name. Errors: InputError naming the kind, or a parameter that the generator does not have."""
        if not isinstance(name, str):
            raise InputError(f"{self.kind}: expected its name as text, got {name!r:.100}")
        if name not in self._generators:
            known = self.generators()
            raise InputError(f"{self.kind}: unknown {self.kind} {name!r}{near(name, known)}; known are {', '.join(known)}")
        found = self._generators[name]
        for key in set(parameters) - found.parameters.keys():
            like, its = near(key, found.parameters), ", ".join(found.parameters)
            raise InputError(f"{key}: the {self.kind} {name} has no such parameter{like}; it has {its}")
        return found


def near(name: str, known: Iterable[str]) -> str:
    """A question that follows the statement that a name is unknown, " (did you mean lemke?)"; "" if no known name is near."""
    found = get_close_matches(name, list(known), n=1)
    return f" (did you mean {found[0]}?)" if found else ""


def import_all(package: str, path: list[str]) -> None:
    """Import every module of a package, whose decorators then register what they define; path: the package's __path__."""
    for module in iter_modules(path):
        import_module(f"{package}.{module.name}")
