"""Siconos's text files: numbers in the order in which its programs print them.

    local friction problem     d, nc, W, q (nc*d), mu (nc)                       u = W r + q
    global friction problem    d, nc, M, H, f (nv), w (nc*d), mu (nc)            M v = H r + f,  u = H' v + w
    LCP                        n, M, q (n)

A matrix begins with its storage type and the numbers of rows and columns. The rest depends on the storage type:

    0, dense     rows and columns again, then the entries by columns
    1, blocks    the number of blocks; block rows and columns and their ends; a CSR pattern of the blocks; each block's
                 number and its entries by columns
    2, sparse    the output of CSparse, to six digits: triplets `row column : value`, or columns of `row : value`

Text after the last number is ignored. A count that exceeds the numbers for which the file has bytes is refused before memory is
allocated for them.
"""

import os
from collections.abc import Iterator
from io import TextIOWrapper
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems.check import Array, InputError, require
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.archive import opened, sparse_matrix
from frictionbench.problems.recorded.forms import from_global

MAX_BYTES = 2**29  # bytes of text; a larger file is refused without reading it
CHUNK = 2**20
Index = NDArray[np.int64]


class _Numbers:
    """The words of a text one after another, converted to the numbers that the format requires."""

    def __init__(self, file: TextIO, size: int) -> None:
        self._words, self._most = _words(file), size // 2 + 1

    def word(self, field: str) -> str:
        word = next(self._words, None)
        require(word is not None, field, "is missing: the file ends before it")
        return str(word)

    def whole(self, field: str, least: int = 0) -> int:
        word = self.word(field)
        try:
            value = int(word.rstrip(","))  # CSparse writes a comma after a number of entries
        except ValueError:
            raise InputError(f"{field}: expected an integer, got {word[:40]!r}") from None
        require(least <= value <= self._most, field, f"{value} is out of range, or more than the file can hold")
        return value

    def reals(self, field: str, count: int) -> Array:
        """The next `count` numbers (count,)."""
        require(count <= self._most, field, f"has {count} numbers by its header, more than the file can hold")
        try:
            values = np.fromiter((float(word) for word in islice(self._words, count)), float)
        except ValueError as error:
            raise InputError(f"{field}: {error}") from None
        require(len(values) == count, field, f"expected {count} numbers, the file ends after {len(values)}")
        return values

    def wholes(self, field: str, count: int, most: int) -> Index:
        """The next `count` integers (count,) between 0 and most."""
        values = self.reals(field, count)
        inside = (values >= 0) & (values <= most) & (values == np.floor(values))
        require(bool(inside.all()), field, f"expected integers between 0 and {most}")
        return values.astype(np.int64)


def _words(file: TextIO) -> Iterator[str]:
    rest = ""
    while chunk := file.read(CHUNK):
        words = (rest + chunk).split()
        rest = words.pop() if words and not chunk[-1].isspace() else ""
        require(len(rest) < 1000, "text", "contains a word of more than a thousand characters")
        yield from words
    yield from rest.split()


def read(path: Path) -> FrictionProblem | LCP:
    """The problem in a text file. Errors: InputError naming the field."""
    with opened(path, MAX_BYTES) as content, TextIOWrapper(content, encoding="ascii", errors="replace") as file:
        size = os.fstat(content.fileno()).st_size
        head = list(islice(_words(file), 7))
        file.seek(0)
        numbers = _Numbers(file, size)
        # Both kinds start with two small integers. In an LCP the second is M's storage, and the first is repeated as M's shape.
        if len(head) > 3 and head[0] == head[2] == head[3] and "CSparse" not in head[6:]:
            n = numbers.whole("n", least=1)
            M = _matrix(numbers, "M")
            require(M.shape == (n, n), "M", f"expected shape {(n, n)}, got {M.shape}")
            return LCP(M, numbers.reals("q", n))
        return _friction(numbers)


def _friction(numbers: _Numbers) -> FrictionProblem:
    d, nc = numbers.whole("dimension"), numbers.whole("contacts")
    require(d in (2, 3), "dimension", f"must be 2 or 3, got {d}")
    first = _matrix(numbers, "first matrix")
    words = numbers.word("storage of H, or q")
    if words in ("0", "1", "2") and first.shape != (nc * d, nc * d):
        H = _matrix(numbers, "H", int(words))
        require(H.shape == (first.shape[0], nc * d), "H", f"expected shape {(first.shape[0], nc * d)}, got {H.shape}")
        f, w, mu = numbers.reals("f", H.shape[0]), numbers.reals("w", nc * d), numbers.reals("mu", nc)
        return from_global(first, H, f, w, mu, d)
    require(first.shape == (nc * d, nc * d), "W", f"expected shape {(nc * d, nc * d)}, got {first.shape}")
    try:
        q = np.concatenate([[float(words)], numbers.reals("q", nc * d - 1)])
    except ValueError as error:
        raise InputError(f"q: {error}") from None
    return FrictionProblem.from_delassus(first, q, numbers.reals("mu", nc), d)


def _matrix(numbers: _Numbers, name: str, storage: int | None = None) -> sparse.csr_array:
    storage = numbers.whole(f"{name}, storage") if storage is None else storage
    require(storage in (0, 1, 2), f"{name}, storage", f"must be 0, 1 or 2, got {storage}")
    m, n = numbers.whole(f"{name}, rows"), numbers.whole(f"{name}, columns")
    return (_dense, _blocks, _sparse)[storage](numbers, name, m, n)


def _dense(numbers: _Numbers, name: str, m: int, n: int) -> sparse.csr_array:
    repeated = numbers.whole(f"{name}, rows"), numbers.whole(f"{name}, columns")
    require(repeated == (m, n), name, f"states the shape {(m, n)} first and {repeated} later")
    return sparse.csr_array(numbers.reals(name, m * n).reshape(n, m).T)


def _blocks(numbers: _Numbers, name: str, m: int, n: int) -> sparse.csr_array:
    count = numbers.whole(f"{name}, number of blocks")
    shape = [numbers.whole(f"{name}, block {axis}") for axis in ("rows", "columns")]
    ends = [numbers.wholes(f"{name}, ends of block rows and columns", k, total) for k, total in zip(shape, (m, n), strict=True)]
    edges = [np.concatenate([[0], end]) for end in ends]
    for edge, total in zip(edges, (m, n), strict=True):
        _require_rising(edge, total, f"{name}, ends of block rows and columns")
    filled = numbers.whole(f"{name}, filled rows"), numbers.whole(f"{name}, filled blocks")
    require(filled == (shape[0] + 1, count), f"{name}, filled", f"expected {(shape[0] + 1, count)}, got {filled}")
    start = numbers.wholes(f"{name}, block pattern", shape[0] + 1, count)
    column = numbers.wholes(f"{name}, block pattern", count, shape[1] - 1)
    _require_rising(start, count, f"{name}, block pattern")
    row = np.repeat(np.arange(shape[0]), np.diff(start))
    rows, columns, values = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty(0)]
    for k in range(count):
        numbers.whole(f"{name}, number of a block")
        (top, bottom), (left, right) = edges[0][row[k] : row[k] + 2], edges[1][column[k] : column[k] + 2]
        values.append(numbers.reals(f"{name}, block {k}", int((bottom - top) * (right - left))))
        rows.append(np.tile(np.arange(top, bottom), right - left))
        columns.append(np.repeat(np.arange(left, right), bottom - top))
    places = np.concatenate(rows), np.concatenate(columns)
    return sparse_matrix(name, sparse.coo_array, (np.concatenate(values), places), (m, n))


def _require_rising(index: Index, last: int, field: str) -> None:
    require(index[0] == 0 and index[-1] == last and bool((np.diff(index) >= 0).all()), field, "not in order")


def _sparse(numbers: _Numbers, name: str, m: int, n: int) -> sparse.csr_array:
    numbers.whole(f"{name}, origin")
    words = ""
    while not words.endswith("nnz: "):
        require(len(words) < 1000, name, "is not in the format that CSparse prints")
        words += numbers.word(name) + " "
    count = numbers.whole(name)
    require(f" {m}-by-{n}, " in f" {words}", name, f"expected {m}-by-{n}")
    if "triplet:" in words:
        entries = [(numbers.whole(name), numbers.whole(name), _after_colon(numbers, name)) for _ in range(count)]
    else:
        numbers.word(name), numbers.reals(f"{name}, 1-norm", 1)
        entries = []
        for column in range(n):
            numbers.word(name), numbers.word(name), numbers.word(name), numbers.word(name)  # col j : locations
            first = numbers.whole(f"{name}, locations")
            numbers.word(name)  # to
            last = numbers.whole(f"{name}, locations", least=-1)
            entries += [(numbers.whole(name), column, _after_colon(numbers, name)) for _ in range(first, last + 1)]
        require(len(entries) == count, name, f"has {len(entries)} entries, but {count} by its header")
    parts = np.array(entries, dtype=float).reshape(-1, 3)
    return sparse_matrix(name, sparse.coo_array, (parts[:, 2], tuple(parts[:, :2].T.astype(np.int64))), (m, n))


def _after_colon(numbers: _Numbers, name: str) -> float:
    require(numbers.word(name) == ":", name, "expected `place : value`")
    return float(numbers.reals(name, 1)[0])
