"""Files that are written atomically and only inside the folder that was given.

A results folder may come from an untrusted source, and a symbolic link in it could redirect what is written. Subfolders that
are symbolic links are therefore refused, and a file is written under a temporary name in the same folder and then renamed,
which replaces a link instead of following it.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


class ResultsError(ValueError):
    """A results folder or file cannot be used; the message names it."""


def subfolder(folder: Path, name: str) -> Path:
    """The folder `folder/name`, created if missing. Errors: ResultsError if it is a symbolic link."""
    path = folder / name
    if path.is_symlink():
        raise ResultsError(f"{path}: is a symbolic link, through which nothing is written; delete it")
    path.mkdir(parents=True, exist_ok=True)
    return path


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary path with the same folder and suffix; the file written there replaces `path` if the block succeeds.

    Errors: OSError naming the path, if the disk is full or the folder is not writable.
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
    """Write a text file atomically as UTF-8; what cannot be encoded is replaced by a question mark."""
    with replaced(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
