"""Files that announce what they define by a decorator only need to be imported: then no list of them is kept anywhere."""

from importlib import import_module
from pkgutil import iter_modules


def import_all(package: str, path: list[str]) -> None:
    """Import every module of a package, rooms below it included as packages; path: the package's __path__."""
    for module in iter_modules(path):
        import_module(f"{package}.{module.name}")
