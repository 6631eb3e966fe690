"""Pipes, devices and links to them in place of files, at which reading would never end, are refused at once."""

import io
import os
import struct
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

from frictionbench.problems import InputError
from frictionbench.problems.recorded import archive, read
from tests.helpers.command_line import frictionbench
from tests.helpers.made_results import SETTINGS, solve_row, write_folder

SPECIAL = ("pipe", "zeros", "folder", "endless")
ROWS = [solve_row("lemke", "abc", verdict="unsolved")]


def put(kind: str, path: Path) -> None:
    """Put something that is no regular file, or states no size, in the place of a file."""
    path.unlink(missing_ok=True)
    path.parent.mkdir(exist_ok=True)
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to({"zeros": "/dev/zero", "endless": "/proc/self/pagemap"}[kind])


FILES = {
    "manifest.json": ["report", "compare", "history", "accept", "export", "rerun", "shrink"],
    "solves.parquet": ["report", "compare", "history", "accept"],
    "simulations.parquet": ["report", "compare"],
    "convergence.json": ["report"],
    "shards/solves-test.jsonl": ["rerun", "shrink"],
    "shards/solves-0.jsonl": ["rerun", "shrink"],
    "problems/source-0.json": ["export"],
    "problems/abc.npz": ["shrink"],
}


@pytest.mark.parametrize("kind", ["pipe", "zeros"])
@pytest.mark.parametrize(("name", "commands"), FILES.items())
def test_special_files_in_a_folder(tmp_path, kind, name, commands) -> None:
    folder = write_folder(tmp_path / "run", ROWS, settings=SETTINGS | {"memory_limit": 2**32})
    good = write_folder(tmp_path / "good", ROWS, settings=SETTINGS | {"memory_limit": 2**32})
    put(kind, folder / name)
    arguments = {
        "report": ["report", str(folder)],
        "compare": ["compare", str(good), str(folder)],
        "history": ["compare", "--history", str(folder)],
        "accept": ["compare", str(tmp_path / "x.tsv"), str(folder), "--accept"],
        "rerun": ["rerun", str(folder), "lemke"],
        "shrink": ["rerun", str(folder), "lemke", "--shrink"],
        "export": ["export", str(folder), "--out", str(tmp_path / "out")],
    }
    for command in commands:
        done = frictionbench(*arguments[command])
        assert done.returncode == 2, (command, done)
        told = done.stderr or done.stdout.partition("against")[2]
        assert len(told.strip().splitlines()) == 1, (command, done)
        assert Path(name).name in told, (command, done)


@pytest.mark.parametrize("kind", SPECIAL)
def test_special_files_as_arguments(tmp_path, kind) -> None:
    good = write_folder(tmp_path / "good", [solve_row("lemke", "p")])
    for name, command in (
        ("a.tsv", ("compare", "FILE", str(good))),
        ("a.tsv", ("compare", "FILE", str(good), "--accept")),
        ("a.json", ("compare", "FILE", "FILE")),
        ("a.npz", ("solve", "FILE")),
        ("a.hdf5", ("solve", "FILE")),
        ("a.toml", ("run", "--config", "FILE")),
        ("a.py", ("check-solver", "FILE")),
    ):
        path = tmp_path / name
        if not path.is_symlink() and not path.exists():
            put(kind, path)
        done = frictionbench(*(str(path) if part == "FILE" else part for part in command))
        assert done.returncode == 2, (command, done)
        assert "Traceback" not in done.stderr


def npz(path: Path, entries: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as packed:
        for name, content in entries.items():
            packed.writestr(f"{name}.npy", content)
    return path


def header(text: str, length: int | None = None) -> bytes:
    """An .npy file of format 2.0 with this header, which claims to be of the given length."""
    content = text.encode()
    return b"\x93NUMPY\x02\x00" + (len(content) if length is None else length).to_bytes(4, "little") + content


def described(shape: str, kind: str = "<f8") -> str:
    return f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}}}\n"


@pytest.mark.parametrize(
    "entry",
    [
        header(" " * 2**27),  # a header of 128 MiB, which unpacks from 128 KiB
        header(described("(3,)"), 2**32 - 1),
        header(described("(-1099511627776,)")),
        header(described("(3,)", "|O")),
        header(described("(3,)", "<U9")),
        header("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (3,)}"),
        header("(" * 9000),
        header(described("(True,)")),
        header(described("(3,)")) + bytes(7),
        b"\x93NUMPY\x09\x00",
    ],
)
def test_headers_of_arrays(tmp_path, entry) -> None:
    content = io.BytesIO()
    np.save(content, np.ones(3))
    for name in ("W", "zzz"):
        path = npz(tmp_path / "a.npz", {"q": content.getvalue(), name: entry})
        with pytest.raises(InputError, match=r"a\.npz: ") as refused:
            read(path)
        assert "\n" not in str(refused.value)


def test_archives_that_unpack_to_much(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(archive, "MAX_BYTES", 2**20)
    many = {f"a{i}": header(described("(30000,)")) + bytes(240_000) for i in range(5)}
    with pytest.raises(InputError, match="unpacks to more than"):
        read(npz(tmp_path / "a.npz", many))
    for method in (zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2):
        with pytest.raises(InputError, match="is compressed by another method than deflate"):
            read(npz(tmp_path / "a.npz", {"W": header(described("(3,)")) + bytes(24)}, method))
    with pytest.raises(InputError, match=r"holds G{80}; expected"):
        read(npz(tmp_path / "a.npz", {"G" * 1000: header(described("(3,)")) + bytes(24)}))
    with pytest.raises(InputError, match="names: hold control characters"):
        read(npz(tmp_path / "a.npz", {"W\x1b[31m\n": b""}))


def test_directory_of_an_archive(tmp_path) -> None:
    """An archive whose directory alone has a hundred thousand entries takes no memory to refuse."""
    entry, path = struct.pack("<4s4B4HL2L5H2L", b"PK\1\2", 20, 3, 20, *[0] * 8, 7, *[0] * 6), tmp_path / "a.npz"
    directory = b"".join(entry + b"%07d" % i for i in range(10**5))
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, 65535, 65535, len(directory), 30, 0)
    path.write_bytes(b"PK\3\4" + bytes(26) + directory + end)
    tracemalloc.start()
    with pytest.raises(InputError, match="holds more than 1000 arrays"):
        read(path)
    assert tracemalloc.get_traced_memory()[1] < 4 * archive.CHUNK
    tracemalloc.stop()
