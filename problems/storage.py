"""A friction problem in a file: one .npz of plain arrays, never pickled.

Every field of FrictionProblem by name; a sparse field F as F_data, F_indices, F_indptr and F_shape. A problem known by its
Delassus matrix holds W and q in place of the mechanical fields.
"""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from problems.check import InputError
from problems.friction import DelassusProblem, FrictionProblem

LARGEST = 4 * 2**30  # bytes unpacked; a larger problem is refused unread
_SPARSE = ("mass", "normal", "tangent", "joints")
_DENSE = ("friction", "free_velocity", "bias", "friction_bias", "joint_bias")


def save(problem: FrictionProblem, path: Path) -> None:
    """Write the problem to path (.npz)."""
    if isinstance(problem, DelassusProblem):
        arrays = {"q": problem.q, "friction": problem.friction, "friction_bias": problem.friction_bias}
        matrices = {"W": problem.W}
    else:
        arrays = {name: getattr(problem, name) for name in _DENSE}
        matrices = {name: getattr(problem, name) for name in _SPARSE}
    for name, matrix in matrices.items():
        parts = {"data": matrix.data, "indices": matrix.indices, "indptr": matrix.indptr, "shape": np.array(matrix.shape)}
        arrays |= {f"{name}_{part}": value for part, value in parts.items()}
    np.savez(path, allow_pickle=False, dimension=np.array(problem.dimension), **arrays)


def load(path: Path) -> FrictionProblem:
    """Read a problem. Errors: InputError naming the file, or the field in it that cannot be used."""
    try:
        _refuse_giants(path)
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, AttributeError) as error:
        raise InputError(f"{path}: not a problem file ({error})") from None
    try:
        dimension = int(arrays["dimension"])
        if "W_data" in arrays:
            W, q, mu, b_f = _matrix(arrays, "W"), arrays["q"], arrays["friction"], arrays["friction_bias"]
            return FrictionProblem.from_delassus(W, q, mu, dimension, b_f)
        matrices = {name: _matrix(arrays, name) for name in _SPARSE}
        return FrictionProblem(**matrices, **{name: arrays[name] for name in _DENSE}, dimension=dimension)
    except KeyError as error:
        raise InputError(f"{path}: field {error.args[0]} is missing") from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None


def _refuse_giants(path: Path) -> None:
    """A small archive can unpack to more than memory holds: look at what it says of itself first."""
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > LARGEST:
        raise ValueError(f"unpacks to {unpacked / 2**30:.1f} GiB, more than {LARGEST / 2**30:g}")


def _matrix(arrays: dict[str, Any], name: str) -> sparse.csr_array:
    data, indices, indptr, shape = (arrays[f"{name}_{part}"] for part in ("data", "indices", "indptr", "shape"))
    try:
        matrix = sparse.csr_array((data, indices, indptr), shape=tuple(int(n) for n in shape))
        matrix.check_format(full_check=True)
    except (ValueError, TypeError, IndexError) as error:
        raise InputError(f"{name}: not a sparse matrix ({error})") from None
    return matrix
