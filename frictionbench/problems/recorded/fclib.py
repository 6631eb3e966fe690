"""FCLIB's HDF5 files (github.com/FrictionalContactLibrary/fclib): local and global problems, with joints, guesses, a solution.

    fclib_local/    spacedim, W, [V, R], vectors/{q, mu, [s]}, info       u = W r + V l + q,  0 = V' r + R l + s
    fclib_global/   spacedim, M, H, [G], vectors/{f, w, mu, [b]}, info    M v = H r + G l + f,  u = H' v + w,  0 = G' v + b
    guesses/        number_of_guesses, 1/{r, u, [v, l]}, 2/...
    solution/       r, u, [v, l]

A matrix is {m, n, nz, nzmax, p, i, x}. nz >= 0 is a number of triplets, in which i is the row and p the column (the library's
header documents them the other way round); -1 means CSC, -2 CSR. Rows per contact, normal first. A stored solution may be a
placeholder and is not used as a reference.

In addition, write() stores frictionbench/free_velocity, because solving M v* = f does not reproduce v* to the last bit.
"""

import os
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems.check import Array, InputError, require, require_installed
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.archive import sparse_matrix
from frictionbench.problems.recorded.forms import from_global, from_local

SUFFIXES = (".hdf5", ".h5")
MAX_BYTES = 2**29  # bytes of all arrays of a file; larger ones are refused
NO_PLUGINS = {"HDF5_PLUGIN_PRELOAD": "::"}  # disables filter plugins: a file could cause their code to be loaded
MAX_SECONDS = 120.0  # seconds after which reading a file is aborted
OURS = "frictionbench/free_velocity"

Arrays = dict[str, Array]


def read(path: Path) -> tuple[FrictionProblem, tuple[Array, ...]]:
    """The problem in an HDF5 file, and the initial guesses (nc, d) of its impulses that the file contains.

    Errors: InputError naming the field.
    """
    arrays = _unpack(path)
    forms = {name.split("/")[0] for name in arrays} & {"fclib_local", "fclib_global"}
    present = " and ".join(sorted(forms)) or "neither"
    require(len(forms) == 1, "fclib_local, fclib_global", f"expected one of them, found {present}")
    form = forms.pop()
    problem = (_local if form == "fclib_local" else _global)(arrays, form)
    shape = (problem.contacts, problem.dimension)
    offered = [arrays[name] for name in sorted(arrays) if name.startswith("guesses/") and name.endswith("/r")]
    guesses = tuple(r.reshape(shape) for r in offered if r.size == shape[0] * shape[1] and np.isfinite(r).all())
    return problem, guesses


def _unpack(path: Path) -> Arrays:
    """All arrays of the file by their paths, read in a separate process: see hdf5_child."""
    require_installed("h5py", "recorded")
    child = Path(__file__).with_name("hdf5_child.py")
    command = [sys.executable, "-P", str(child), str(path.resolve()), str(MAX_BYTES)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=MAX_SECONDS, check=False, env=os.environ | NO_PLUGINS)
    except subprocess.TimeoutExpired:
        raise InputError(f"HDF5: reading was aborted after {MAX_SECONDS:g} s") from None
    if done.returncode == 2:
        raise InputError(repr(done.stderr.decode(errors="replace"))[1:-1])  # names in a file may contain line breaks
    require(done.returncode == 0, "HDF5", "the library crashed while reading the file")
    with np.load(BytesIO(done.stdout), allow_pickle=False) as stored:
        return {name.replace("|", "/")[1:]: stored[name] for name in stored.files}


def _local(arrays: Arrays, form: str) -> FrictionProblem:
    d, mu = _dimension(arrays, form), _vector(arrays, f"{form}/vectors/mu")
    parts = (_matrix(arrays, f"{form}/W"), _vector(arrays, f"{form}/vectors/q"), mu, d)
    if f"{form}/V/nz" not in arrays:
        return from_local(*parts)
    return from_local(*parts, _matrix(arrays, f"{form}/V"), _matrix(arrays, f"{form}/R"), _vector(arrays, f"{form}/vectors/s"))


def _global(arrays: Arrays, form: str) -> FrictionProblem:
    d, mu = _dimension(arrays, form), _vector(arrays, f"{form}/vectors/mu")
    M, H = (_matrix(arrays, f"{form}/{name}") for name in ("M", "H"))
    f, w = (_vector(arrays, f"{form}/vectors/{name}") for name in ("f", "w"))
    joined = f"{form}/G/nz" in arrays
    G, b = (_matrix(arrays, f"{form}/G"), _vector(arrays, f"{form}/vectors/b")) if joined else (None, None)
    problem = from_global(M, H, f, w, mu, d, G, b)
    free = arrays.get(OURS)
    if free is None or not problem.mechanical or free.shape != f.shape or not np.array_equal(M @ free, f):
        return problem
    return problem.replace(free_velocity=free)


def _dimension(arrays: Arrays, form: str) -> int:
    d = _whole(arrays, f"{form}/spacedim")
    require(d in (2, 3), f"{form}/spacedim", f"must be 2 or 3, got {d}")
    return d


def _whole(arrays: Arrays, field: str) -> int:
    value = _index(arrays, field)
    require(value.size == 1, field, "expected one integer")
    return int(value[0])


def _vector(arrays: Arrays, field: str) -> Array:
    require(field in arrays, field, "missing")
    require(arrays[field].ndim == 1, field, f"expected a vector, got shape {arrays[field].shape}")
    return arrays[field].astype(float)


def _matrix(arrays: Arrays, field: str) -> sparse.csr_array:
    m, n, nz = (_whole(arrays, f"{field}/{name}") for name in ("m", "n", "nz"))
    x, i, p = _vector(arrays, f"{field}/x"), _index(arrays, f"{field}/i"), _index(arrays, f"{field}/p")
    for name, size in (("m", m), ("n", n)):
        require(0 <= size <= MAX_BYTES // 8, f"{field}/{name}", f"{size} is out of range")
    if nz >= 0:
        for name, value in (("i", i), ("p", p), ("x", x)):
            require(len(value) >= nz, f"{field}/{name}", f"expected {nz} entries, got {len(value)}")
        return sparse_matrix(field, sparse.coo_array, (x[:nz], (i[:nz], p[:nz])), (m, n))
    require(nz in (-1, -2), f"{field}/nz", f"must be -2, -1 or a number of entries, got {nz}")
    return sparse_matrix(field, sparse.csc_array if nz == -1 else sparse.csr_array, (x, i, p), (m, n))


def _index(arrays: Arrays, field: str) -> NDArray[np.int64]:
    require(field in arrays, field, "missing")
    require(arrays[field].dtype.kind in "iu", field, "expected integers")
    return arrays[field].ravel().astype(np.int64)


def write(problem: FrictionProblem, path: Path, title: str = "", description: str = "") -> None:
    """Write FCLIB's local form if only W is known, and otherwise its global form, in triplets.

    Errors: InputError if FCLIB's format cannot represent the problem.
    """
    require(not problem.friction_bias.any(), "friction_bias", "FCLIB's format cannot represent it")
    require_installed("h5py", "recorded")
    import h5py

    content = BytesIO()  # HDF5 may end the process at a full disk
    with h5py.File(content, "w") as file:
        local = not problem.mechanical
        group = file.create_group("fclib_local" if local else "fclib_global")
        group["spacedim"] = _integer(problem.dimension)
        for name, text in {"title": title, "description": description, "math_info": ""}.items():
            group[f"info/{name}"] = np.bytes_(text.encode("ascii", "replace") or b"\0")
        if local:
            matrices, vectors = {"W": problem.W}, {"q": problem.q}
        else:
            offset = np.zeros((problem.contacts, problem.dimension))
            offset[:, 0] = problem.bias
            matrices = {"M": problem.mass, "H": sparse.csr_array(problem.jacobian.T)}
            vectors = {"f": problem.mass @ problem.free_velocity, "w": offset.ravel()}
            if problem.joints.shape[0]:
                matrices["G"], vectors["b"] = sparse.csr_array(problem.joints.T), problem.joint_bias
            file[OURS] = problem.free_velocity
        for name, matrix in matrices.items():
            entries, matrix_group = matrix.tocoo(), group.create_group(name)
            sizes = {"m": matrix.shape[0], "n": matrix.shape[1], "nz": -2 if local else matrix.nnz, "nzmax": matrix.nnz}
            for size, value in sizes.items():
                matrix_group[size] = _integer(value)
            matrix_group["p"] = (matrix.indptr if local else entries.col).astype(np.int32)
            matrix_group["i"] = (matrix.indices if local else entries.row).astype(np.int32)
            matrix_group["x"] = matrix.data if local else entries.data
        for name, vector in (vectors | {"mu": problem.friction}).items():
            group[f"vectors/{name}"] = vector
    path.write_bytes(content.getbuffer())


def _integer(value: int) -> Array:
    return np.array([value], dtype=np.int32)
