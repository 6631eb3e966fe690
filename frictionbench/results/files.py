"""Untrusted files: read only if they are regular and not too large, and written atomically inside the given folder.

A results folder may come from an untrusted source. A symbolic link in it could redirect what is written. Subfolders that are
links are therefore refused, and a file is written under a temporary name in the same folder and then renamed, which replaces a
link. A file could be a pipe or a device, from which a read never returns, so that every file is opened by `opened`. Texts may
contain characters that control a terminal or a browser, so that texts of files and replies pass through `cleaned` once.
"""

import json
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, TypeVar
from unicodedata import category

from frictionbench.regular import regular

T = TypeVar("T")

LARGEST_JSON = 32 * 2**20  # bytes: several times the longest recorded motion; about ten times as much memory once parsed


class ResultsError(ValueError):
    """A results folder or file cannot be used; the message names it."""


@contextmanager
def opened(path: Path, most: int) -> Iterator[BinaryIO]:
    """Open a regular file of at most `most` bytes for reading.

    Errors: ResultsError naming the file if it is not regular or is larger, FileNotFoundError if it is missing.
    """
    try:
        with regular(path, most) as file:
            yield file
    except FileNotFoundError:
        raise
    except OSError as error:
        raise ResultsError(f"{path}: cannot be read ({' '.join(str(error.strerror or error).split())})") from None


def read_text(path: Path, most: int) -> str:
    """Read a text file, with line ends as `\\n`. Errors: as for `opened`, and ResultsError if it is not UTF-8."""
    with opened(path, most) as file:
        content = file.read(most)
    try:
        return content.decode().replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None


def read_json(path: Path, most: int = LARGEST_JSON) -> Any:
    """Read the value in a JSON file, `cleaned`. Errors: as for read_text, and ResultsError if it is not valid JSON in UTF-8."""
    text = read_text(path, most)
    try:
        value = json.loads(text)
        json.dumps(value, ensure_ascii=False).encode()  # raises for a lone surrogate
        return cleaned(value)
    except RecursionError:
        raise ResultsError(f"{path}: cannot be read (nested too deeply)") from None
    except ValueError as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None


def parsed(value: Any, kind: type[T], where: Path | str) -> T:
    """Convert a value to a type, which may be a tuple or a class with annotated fields.

    Errors: ResultsError naming its origin and the part that cannot be used.
    """
    from pydantic import TypeAdapter, ValidationError  # the command line imports this file for its help

    try:
        return TypeAdapter(kind).validate_python(value)
    except ValidationError as error:
        first = error.errors()[0]
        place = " ".join(str(part + 1 if isinstance(part, int) else part) for part in first["loc"])
        message = printable(f"{place}: {first['msg']}")
        raise ResultsError(f"{where}: cannot be read ({message})") from None


def read_parsed(path: Path, kind: type[T], missing: T | None = None) -> T:
    """Read a JSON file as a value of a type. missing: the value to return if there is no file.

    Errors: FileNotFoundError; ResultsError naming the file if it cannot be read or holds another type.
    """
    return missing if missing is not None and not path.exists() else parsed(read_json(path), kind, path)


def json_text(value: Any) -> str:
    """Return the value as valid JSON: numbers that are infinite or NaN become null."""
    from pydantic_core import to_jsonable_python

    return json.dumps(to_jsonable_python(value, inf_nan_mode="null", fallback=lambda other: other.item()), indent=1)


def cleaned(value: Any) -> Any:
    """Replace characters that control a terminal, the writing direction or lines, except tabs and line ends, by question marks
    in a text or in all texts of a JSON value. Spaces of all kinds are kept, since paths contain them."""
    if isinstance(value, str) and not value.isprintable():
        kept = {c for c in set(value) if c.isprintable() or c in "\t\n" or category(c) == "Zs"}
        return "".join(c if c in kept else "?" for c in value)
    if isinstance(value, list):
        return [cleaned(entry) for entry in value]
    return {cleaned(name): cleaned(entry) for name, entry in value.items()} if isinstance(value, dict) else value


def printable(text: str) -> str:
    """Return the text on one line, `cleaned`."""
    return str(cleaned(" ".join(text.split())))


def subfolder(folder: Path, name: str) -> Path:
    """Return the folder `folder/name`, created if missing. Errors: ResultsError if it is a symbolic link."""
    path = folder / name
    if path.is_symlink():
        raise ResultsError(f"{path}: is a symbolic link, through which nothing is written; delete it")
    path.mkdir(parents=True, exist_ok=True)
    return path


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """Provide a temporary path with the same folder and suffix. The file written there replaces `path` if the block succeeds.

    Errors: OSError naming the path if the disk is full or the folder is not writable.
    """
    partial = path.with_name(f".{path.stem}-{secrets.token_hex(8)}{path.suffix}")
    try:
        partial.touch(exist_ok=False)
        yield partial
        partial.replace(path)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    finally:
        with suppress(OSError):  # it was renamed or never created
            partial.unlink()


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically as UTF-8. Characters that cannot be encoded are replaced by question marks."""
    with replaced(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
