"""Location of recorded problems from other projects, and writers of their file formats for tests."""

import os
from pathlib import Path

import pytest

DEFAULT_FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data"
FOLDER = Path(os.environ.get("FRICTIONBENCH_RECORDED", DEFAULT_FOLDER))


def recorded(folder: str, pattern: str = "*") -> list:
    """The files of a subfolder as parameters of a test, or one that skips it with the reason."""
    files = sorted(path for path in (FOLDER / folder).glob(pattern) if path.is_file())
    if not files:
        reason = f"no recorded problems: FRICTIONBENCH_RECORDED names no folder with {folder}/{pattern}"
        return [pytest.param(None, marks=pytest.mark.skip(reason=reason))]
    return [pytest.param(path, id=path.name) for path in files]


def numbers(values) -> str:
    return " ".join(repr(float(value)) for value in values)


def dense(matrix) -> str:
    """As Siconos prints a dense matrix: by columns."""
    m, n = matrix.shape
    return f"0\n{m}\n{n}\n{m}\t{n}\n{numbers(matrix.toarray().T.ravel())}\n"


def triplets(matrix) -> str:
    """As CSparse prints triplets."""
    m, n = matrix.shape
    entries = matrix.tocoo()
    lines = [f"    {i} {j} : {x!r}" for i, j, x in zip(entries.row, entries.col, entries.data.tolist(), strict=True)]
    head = f"2\n{m}\n{n}\n1\nCSparse Version 3.1.9, May 4, 2016.  Copyright (c) Timothy A. Davis, 2006-2016\n"
    return head + "\n".join([f"triplet: {m}-by-{n}, nzmax: {len(lines)} nnz: {len(lines)}", *lines]) + "\n"


def columns(matrix) -> str:
    """As CSparse prints a matrix by columns."""
    (m, n), by_column = matrix.shape, matrix.tocsc()
    lines = [f"{m}-by-{n}, nzmax: {matrix.nnz} nnz: {matrix.nnz}, 1-norm: {abs(matrix).sum(axis=0).max():g}"]
    for j in range(n):
        begin, end = by_column.indptr[j : j + 2]
        lines.append(f"    col {j} : locations {begin} to {end - 1}")
        lines += [f"      {by_column.indices[k]} : {float(by_column.data[k])!r}" for k in range(begin, end)]
    return f"2\n{m}\n{n}\n2\nCSparse Version 3.1.9, May 4, 2016.  Copyright (c)\n" + "\n".join(lines) + "\n"


def blocks(matrix, d: int) -> str:
    """As Siconos prints a matrix of d by d blocks: the blocks that hold anything, their entries by columns."""
    rows = matrix.tobsr(blocksize=(d, d))
    nc, count = matrix.shape[0] // d, len(rows.indices)
    ends = " ".join(str(d * (k + 1)) for k in range(nc))
    head = f"1\n{nc * d}\n{nc * d}\n{count}\n{nc}\n{nc}\n{ends}\n{ends}\n{nc + 1}\n{count}\n"
    pattern = " ".join(map(str, rows.indptr)) + "\n" + " ".join(map(str, rows.indices)) + "\n"
    return head + pattern + "".join(f"{k}\n{numbers(block.T.ravel())}\n" for k, block in enumerate(rows.data))
