"""Download of FCLIB's public collection of recorded problems: github.com/FrictionalContactLibrary/fclib-library.

fclib_registry.csv, in the folder of this file, lists 15 of its families with the size and sha256 of each file as of May 2024
(commit 3e2066ef). The repository states no licence, so this project contains nothing of it. Its files are stored by git-LFS,
downloaded from the branch master, and refused if their sha256 has changed. Fetched files are stored in the cache folder,
FRICTIONBENCH_CACHE or by default the user's, and read from there without a network. An interrupted download resumes at the file
where it stopped.
"""

import csv
import os
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

from platformdirs import user_cache_dir

from frictionbench.problems.check import InputError, require, require_installed

DOWNLOAD_URL = "https://media.githubusercontent.com/media/FrictionalContactLibrary/fclib-library/master/"
REGISTRY = Path(__file__).with_name("fclib_registry.csv")


class Entry(NamedTuple):
    """One file of the collection: its path in the repository, its size in bytes and its sha256."""

    path: str
    size: int
    sha256: str


@cache
def registry() -> dict[str, tuple[Entry, ...]]:
    """The files by family, for example Local/siconos/Capsules."""
    families: dict[str, list[Entry]] = {}
    with REGISTRY.open(encoding="ascii", newline="") as file:
        for row in csv.DictReader(file):
            families.setdefault(row["path"].rpartition("/")[0], []).append(Entry(row["path"], int(row["bytes"]), row["sha256"]))
    return {name: tuple(entries) for name, entries in sorted(families.items())}


def family(name: str) -> str:
    """The family to which fclib/NAME refers by its whole path or the last part of it; local families come before global ones.

    Errors: InputError naming the unknown family.
    """
    wanted = name.removeprefix("fclib/").strip("/").lower()
    exact = [known for known in registry() if known.lower() == wanted]
    last = [known for known in registry() if known.lower().endswith(f"/{wanted}")]
    matches = exact or sorted(last, key=lambda known: not known.startswith("Local/"))
    require(bool(matches), "family", f"unknown family {name!r}; known are {', '.join(f'fclib/{one}' for one in registry())}")
    return matches[0]


def cache_folder() -> Path:
    """The folder in which fetched files are stored, each under its path in the repository."""
    return Path(os.environ.get("FRICTIONBENCH_CACHE") or user_cache_dir("frictionbench")) / "fclib"


def fetch(name: str) -> Iterator[Entry]:
    """Download the missing files of a family one after another, check each, and yield it when it is stored.

    They come from DOWNLOAD_URL, or from a mirror given by FRICTIONBENCH_FCLIB.
    Errors: InputError naming a file that cannot be downloaded or differs from the registry, or pooch if it is not installed.
    """
    require_installed("pooch", "recorded")
    import pooch

    address = os.environ.get("FRICTIONBENCH_FCLIB", DOWNLOAD_URL).rstrip("/")
    for entry in registry()[name]:
        path = cache_folder() / entry.path
        try:
            require(not path.is_symlink(), str(path), "is a link; nothing was written")
            require(path.is_file() or not path.exists(), str(path), "is no regular file; nothing was written")
            pooch.retrieve(
                f"{address}/{entry.path}",
                known_hash=f"sha256:{entry.sha256}",
                fname=path.name,
                path=path.parent,
                downloader=partial(_download, entry.size),
            )
        except (OSError, ValueError) as error:  # requests' own errors are OSErrors, a wrong hash is a ValueError
            raise InputError(f"{entry.path}: {' '.join(str(error).split())[:300]}") from None
        yield entry


def _download(size: int, url: str, output_file: str, pooch: object) -> None:
    """Download a file of known size. Errors: InputError as soon as it is longer, or if it is shorter."""
    import requests

    with requests.get(url, stream=True, timeout=30, allow_redirects=True) as response:
        response.raise_for_status()
        left = size
        with open(output_file, "wb") as file:
            for chunk in response.iter_content(2**16):
                left -= len(chunk)
                if left < 0:
                    raise InputError(f"longer than the {size} bytes of the registry")
                file.write(chunk)
        if left:
            raise InputError(f"{size - left} bytes of {size}")
