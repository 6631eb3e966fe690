"""Import of all modules of a package, whose decorators then register what they define; no list of them is needed."""

from importlib import import_module
from pkgutil import iter_modules


def import_all(package: str, path: list[str]) -> None:
    """Import every module of a package, subpackages included; path: the package's __path__."""
    for module in iter_modules(path):
        import_module(f"{package}.{module.name}")
