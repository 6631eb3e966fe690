"""Files written whole or not at all, and only below the folder that was given.

A results folder may come from anybody: a symbolic link in it could lead any file we write to where its owner likes. Folders
below it that are links are refused; files are written beside their place and renamed, which replaces a link and never follows
it.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


class ResultsError(ValueError):
    """A results folder or file that cannot be used; the message names it."""


def room(folder: Path, name: str) -> Path:
    """folder/name as a folder of its own, made where it is missing. Errors: ResultsError where it is a symbolic link."""
    path = folder / name
    if path.is_symlink():
        raise ResultsError(f"{path}: a symbolic link; nothing is written through it")
    path.mkdir(parents=True, exist_ok=True)
    return path


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A path beside `path`, of the same suffix, to be written; it takes the place of `path` where the block succeeds.

    Errors: OSError naming the path, where the disk is full or the folder may not be written.
    """
    try:
        descriptor, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    os.close(descriptor)
    partial = Path(name)
    try:
        yield partial
        partial.chmod(0o666 & ~_umask())
        partial.replace(path)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    finally:
        with suppress(FileNotFoundError):
            partial.unlink()


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all; what is no character is replaced."""
    with replaced(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
