"""The native file format of friction problems and bare LCPs: one .npz of plain arrays.

Every field of FrictionProblem by its name, dense fields as they are, a sparse one F as the four arrays of its CSR form:

    dimension                      2 planar, 3 spatial
    friction (nc), free_velocity (nv), bias (nc), friction_bias (nc), joint_bias (nj)
    mass, normal, tangent, joints  (nv, nv), (nc, nv), (nc*(d-1), nv), (nj, nv), each as F_data, F_indices, F_indptr, F_shape

A problem in Delassus form has W (as W_data ...) and q (nc*d) in place of the mechanical fields, rows per contact, normal first.
A bare LCP has M (n, n) and q (n), and its dimension is 0. problems.recorded.plain reads dense arrays under shorter names.
A step of an engine has the impulses that the engine used besides (problems.recorded.engine_step).
"""

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array, InputError, require, require_consistent
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded import engine_step
from frictionbench.problems.recorded.archive import read_arrays
from frictionbench.problems.recorded.engine_step import EngineStep
from frictionbench.problems.recorded.names import require_known

_SPARSE = ("mass", "normal", "tangent", "joints")
_DENSE = ("friction", "free_velocity", "bias", "friction_bias", "joint_bias")
_PARTS = ("data", "indices", "indptr", "shape")


def save(problem: FrictionProblem | LCP, path: Path, extras: Mapping[str, Array] | None = None) -> None:
    """Write the problem to path (.npz), with the further arrays of an engine's step, if any."""
    dimension = 0
    if isinstance(problem, LCP):
        arrays, matrices = {"q": problem.q}, {"M": problem.M}
    elif not problem.mechanical:
        arrays = {"q": problem.q, "friction": problem.friction, "friction_bias": problem.friction_bias}
        matrices = {"W": problem.W}
        dimension = problem.dimension
    else:
        arrays = {name: getattr(problem, name) for name in _DENSE}
        matrices = {name: getattr(problem, name) for name in _SPARSE}
        dimension = problem.dimension
    for name, matrix in matrices.items():
        parts = {"data": matrix.data, "indices": matrix.indices, "indptr": matrix.indptr, "shape": np.array(matrix.shape)}
        arrays |= {f"{name}_{part}": value for part, value in parts.items()}
    np.savez(path, allow_pickle=False, dimension=np.array(dimension), **arrays, **(extras or {}))


def load(path: Path) -> FrictionProblem | LCP:
    """Read a problem. Errors: InputError naming the file, or the field in it that cannot be used."""
    return problem(path, read_arrays(path))


def holds(names: Collection[str]) -> bool:
    """Whether arrays of these names are of this format."""
    return "dimension" in names and any(name.endswith("_data") for name in names)


def problem(path: Path, arrays: dict[str, Array]) -> FrictionProblem | LCP:
    """The problem that the arrays of a file hold. Errors: InputError naming the file and the field."""
    return _read(path, arrays)[0]


def load_step(path: Path) -> EngineStep:
    """Read a step of an engine. Errors: InputError naming the file, or the field in it that cannot be used."""
    arrays = read_arrays(path)
    require(holds(arrays), str(path), "not a file of fb.save: it cannot hold what an engine answered")
    _, step = _read(path, arrays)
    if step is None:
        raise InputError(f"{path}: holds a problem, but not the impulses that an engine used")
    return step


def _read(path: Path, arrays: dict[str, Array]) -> tuple[FrictionProblem | LCP, EngineStep | None]:
    """The problem, and the step of an engine where the file holds one."""
    try:
        require_known(arrays, _names(arrays))
        found = _problem(arrays)
        if isinstance(found, LCP) or not arrays.keys() & {*engine_step.NAMES}:
            return found, None
        return found, engine_step.unpacked(found, arrays)
    except KeyError as error:
        raise InputError(f"{path}: field {error.args[0]} is missing") from None
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: {error}") from None


def _problem(arrays: dict[str, Array]) -> FrictionProblem | LCP:
    dimension = arrays["dimension"].item()
    require(dimension in (0, 2, 3), "dimension", f"must be 2 or 3, or 0 for an LCP, got {dimension!r}")
    dimension = int(dimension)
    if dimension == 0:
        return LCP(_matrix(arrays, "M"), arrays["q"])
    if "W_data" in arrays:
        W, q, mu, b_f = _matrix(arrays, "W"), arrays["q"], arrays["friction"], arrays["friction_bias"]
        return FrictionProblem.from_delassus(W, q, mu, dimension, b_f)
    matrices = {name: _matrix(arrays, name) for name in _SPARSE}
    return FrictionProblem(**matrices, **{name: arrays[name] for name in _DENSE}, dimension=dimension)


def _names(arrays: Collection[str]) -> set[str]:
    """The names that belong together with those of these arrays."""
    groups: tuple[tuple[str, ...], tuple[str, ...]] = _SPARSE, _DENSE
    if "M_data" in arrays:
        groups = ("M",), ("q",)
    elif "W_data" in arrays:
        groups = ("W",), ("q", "friction", "friction_bias")
    matrices, dense = groups
    extras = () if "M_data" in arrays else engine_step.NAMES
    return {"dimension", *dense, *extras, *(f"{name}_{part}" for name in matrices for part in _PARTS)}


def _matrix(arrays: dict[str, Array], name: str) -> sparse.csr_array:
    data, indices, indptr, shape = (arrays[f"{name}_{part}"] for part in _PARTS)
    try:
        matrix = sparse.csr_array((data, indices, indptr), shape=tuple(int(n) for n in shape))
    except (ValueError, TypeError, IndexError, OverflowError) as error:
        raise InputError(f"{name}: not a sparse matrix ({error})") from None
    require_consistent(name, matrix)
    return matrix
