"""The native file format of friction problems and bare LCPs: one .npz of plain arrays.

Every field of FrictionProblem is stored by its name, a dense one as an array and a sparse one F as the four arrays of its CSR:

    dimension                      2 planar, 3 spatial
    friction (nc), free_velocity (nv), bias (nc), friction_bias (nc), joint_bias (nj)
    mass, normal, tangent, joints  (nv, nv), (nc, nv), (nc*(d-1), nv), (nj, nv), each as F_data, F_indices, F_indptr, F_shape

A problem in Delassus form has W (as W_data ...) and q (nc*d) in place of the mechanical fields, rows per contact, normal first.
A bare LCP has M (n, n) and q (n), and its dimension is 0. problems.recorded.plain reads dense arrays under shorter names.
A step of an engine has up to three further arrays, of which the first is required:

    impulse (nc, d)    N s, normal first: the impulses of the engine
    step               s, the length of the step, if the bias is the gap divided by it
    notes (bytes)      a JSON object in UTF-8: effects that the problem does not express, with their share of the impulse
"""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array, InputError, ReadOnly, require
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem, GivenDelassus
from frictionbench.problems.recorded.archive import read_arrays, require_known, sparse_matrix

LCP_FIELDS = ("M", "q")
_MATRICES = {"mass", "normal", "tangent", "joints", "W", "M"}
_PARTS = ("data", "indices", "indptr", "shape")
NAMES = ("impulse", "step", "notes")  # the arrays of an engine's step
MOST_NOTES, LONGEST_NOTE = 100, 200  # the limits of the number of notes and of the characters of each
LARGEST_NOTES = 2**16  # the limit of the bytes of all notes


@dataclass(frozen=True, eq=False)
class EngineStep(ReadOnly):
    """One step of an engine.

    problem: mechanics, contacts and friction of the step, with the free velocity, which is that without contact impulses.
    impulse: (nc, d), N s, normal first: the engine's impulses, for which `problem.velocity` is the engine's next velocity.
    notes: the effects that the problem does not express, by name, with their share of the impulse, from 0 to 1.
    step: s, the length of the step if problem.bias is the gap divided by it; otherwise None.
    Errors: InputError naming impulse, notes or step.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=1).problem()
    >>> step = fb.EngineStep(problem, fb.solve(problem, "lemke").impulse, {"soft contacts": 0.01})
    >>> step.save("steps").name
    'step_000001.npz'
    """

    problem: FrictionProblem
    impulse: Array
    notes: Mapping[str, float] = field(default_factory=dict)
    step: float | None = None

    def __post_init__(self) -> None:
        shape = self.problem.contacts, self.problem.dimension
        flat = check.vector("impulse", check.floats("impulse", self.impulse).ravel(), shape[0] * shape[1])
        object.__setattr__(self, "impulse", flat.reshape(shape))
        object.__setattr__(self, "notes", _checked(self.notes))
        if self.step is not None:
            object.__setattr__(self, "step", check.number("step", self.step, above=0))

    def __repr__(self) -> str:
        noted = "".join(f", {name} {100 * share:.2f} %" for name, share in self.notes.items())
        return f"EngineStep({self.problem.summary}{noted})"

    def save(self, folder: str | Path) -> Path:
        """Write the step to folder/step_000001.npz, or the number after the last existing one; create the folder if missing.

        Returns the path. Errors: OSError if the file cannot be written.
        """
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        numbers = [int(name) for path in folder.glob("step_*.npz") if (name := path.stem.removeprefix("step_")).isdecimal()]
        path = folder / f"step_{max(numbers, default=0) + 1:06}.npz"
        save(self, path)
        return path


def save(stored: FrictionProblem | LCP | EngineStep, path: Path) -> None:
    """Write a problem or a step to path (.npz)."""
    problem = stored.problem if isinstance(stored, EngineStep) else stored
    dimension, fields = (0, LCP_FIELDS) if isinstance(problem, LCP) else (problem.dimension, problem.FIELDS)
    values = {name: getattr(problem, name) for name in fields}
    arrays = {name: value for name, value in values.items() if name not in _MATRICES}
    for name, matrix in values.items():
        if name in _MATRICES:
            parts = {"data": matrix.data, "indices": matrix.indices, "indptr": matrix.indptr, "shape": np.array(matrix.shape)}
            arrays |= {f"{name}_{part}": value for part, value in parts.items()}
    if isinstance(stored, EngineStep):
        arrays["impulse"] = stored.impulse
        if stored.step is not None:
            arrays["step"] = np.array(stored.step)
        if stored.notes:
            arrays["notes"] = np.frombuffer(json.dumps(dict(stored.notes), ensure_ascii=False).encode(), dtype=np.uint8)
    np.savez(path, allow_pickle=False, dimension=np.array(dimension), **arrays)


def load(path: Path) -> FrictionProblem | LCP:
    """Read a problem. Errors: InputError naming the file and the invalid field."""
    return read(path, read_arrays(path))[0]


def holds(names: Collection[str]) -> bool:
    """Whether arrays with these names are in this format."""
    return "dimension" in names and any(name.endswith("_data") for name in names)


def load_step(path: Path) -> EngineStep:
    """Read a step of an engine. Errors: InputError naming the file and the invalid field."""
    arrays = read_arrays(path)
    require(holds(arrays), str(path), "not a file of fb.save: it cannot hold what an engine answered")
    _, step = read(path, arrays)
    if step is None:
        raise InputError(f"{path}: holds a problem, but not the impulses that an engine used")
    return step


def read(path: Path, arrays: dict[str, Array]) -> tuple[FrictionProblem | LCP, EngineStep | None]:
    """The problem in a file's arrays, and the step of an engine if it has one. Errors: InputError naming file and field."""
    try:
        require_known(arrays, _names(arrays))
        problem_read = _problem(arrays)
        if isinstance(problem_read, LCP) or not arrays.keys() & {*NAMES}:
            return problem_read, None
        require("impulse" in arrays, "impulse", "is missing: the file holds a problem, but not what an engine answered")
        expected, shape = (problem_read.contacts, problem_read.dimension), arrays["impulse"].shape
        require(shape == expected, "impulse", f"expected shape {expected}, got {shape}")
        step = arrays.get("step")
        require(step is None or step.size == 1, "step", "expected a number")
        notes = _text(arrays["notes"]) if "notes" in arrays else {}
        return problem_read, EngineStep(problem_read, arrays["impulse"], notes, None if step is None else float(step.item()))
    except KeyError as error:
        raise InputError(f"{path}: field {error.args[0]} is missing") from None
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: {error}") from None


def _problem(arrays: dict[str, Array]) -> FrictionProblem | LCP:
    dimension = arrays["dimension"].item()
    require(dimension in (0, 2, 3), "dimension", f"must be 2 or 3, or 0 for an LCP, got {dimension!r}")
    dimension = int(dimension)
    fields = _fields(arrays, dimension == 0)
    values: dict[str, Any] = {name: _matrix(arrays, name) if name in _MATRICES else arrays[name] for name in fields}
    if dimension == 0:
        return LCP(**values)
    if "W" in values:
        return FrictionProblem.from_delassus(**values, d=dimension)
    return FrictionProblem(**values, dimension=dimension)


def _fields(arrays: Collection[str], lcp: bool) -> tuple[str, ...]:
    """The fields of a problem with arrays of these names."""
    return LCP_FIELDS if lcp else GivenDelassus.FIELDS if "W_data" in arrays else FrictionProblem.FIELDS


def _names(arrays: Collection[str]) -> set[str]:
    """All array names that are allowed in a file with these arrays."""
    fields = {*_fields(arrays, "M_data" in arrays)}
    parts = {f"{name}_{part}" for name in fields & _MATRICES for part in _PARTS}
    return {"dimension", *(fields - _MATRICES), *parts, *(() if "M" in fields else NAMES)}


def _matrix(arrays: dict[str, Array], name: str) -> sparse.csr_array:
    *parts, shape = (arrays[f"{name}_{part}"] for part in _PARTS)
    return sparse_matrix(name, sparse.csr_array, tuple(parts), shape)


def _text(stored: Array) -> Any:
    usable = stored.dtype == np.uint8 and stored.ndim == 1 and stored.size <= LARGEST_NOTES
    require(usable, "notes", "not the bytes of a short text")
    try:
        return json.loads(stored.tobytes().decode())
    except (ValueError, RecursionError):
        raise InputError("notes: not a JSON object in UTF-8") from None


def _checked(notes: Any) -> dict[str, float]:
    few = isinstance(notes, Mapping) and len(notes) <= MOST_NOTES
    require(few, "notes", f"expected at most {MOST_NOTES} names, each with a share")
    for name in notes:
        usable = isinstance(name, str) and 0 < len(name) <= LONGEST_NOTE and name.isprintable()
        require(usable, "notes", f"a name is a printable text of 1 to {LONGEST_NOTE} characters, got {name!r:.80}")
    return {name: check.number(f"notes: {name}", share, least=0, most=1) for name, share in notes.items()}
