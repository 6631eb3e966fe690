"""One step of an engine: a problem with the impulses that the engine used, and notes on what the problem does not express.

In a file of problems.recorded.own three more arrays, of which the first makes the file an engine's step:

    impulse (nc, d)    N s, the normal first
    step               s, the length of the step, where the bias is the gap over it
    notes (bytes)      a JSON object in UTF-8: what the problem does not express, and its share of the impulse
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from frictionbench.problems import check
from frictionbench.problems.check import Array, InputError, ReadOnly, require
from frictionbench.problems.friction import FrictionProblem

NAMES = ("impulse", "step", "notes")
MOST, LONGEST = 100, 200  # notes, and characters of each: a note is a term, not a text
LARGEST = 2**16  # bytes of all notes


@dataclass(frozen=True, eq=False)
class EngineStep(ReadOnly):
    """One step of an engine.

    problem: mechanics, contacts and friction of the step, with the free velocity, that without contact impulses.
    impulse: (nc, d), N s, the normal first: what the engine used. With it `problem.velocity` is the engine's next velocity.
    notes: what the problem does not express, by name, with its share of the impulse, from 0 to 1.
    step: s, its length, given where problem.bias is the gap over it; None where it is not.
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
            object.__setattr__(self, "step", _number("step", self.step))
            require(self.step > 0, "step", f"must be positive, got {self.step:g}")

    def __repr__(self) -> str:
        noted = "".join(f", {name} {100 * share:.2g} %" for name, share in self.notes.items())
        return f"EngineStep({self.problem.summary}{noted})"

    def save(self, folder: str | Path) -> Path:
        """Write it to folder/step_000001.npz or the first number after those that are there; the folder is made if missing.

        Returns the path. Errors: OSError where the file cannot be written.
        """
        from frictionbench.problems.recorded import own

        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        numbers = [int(name) for path in folder.glob("step_*.npz") if (name := path.stem.removeprefix("step_")).isdecimal()]
        path = folder / f"step_{max(numbers, default=0) + 1:06}.npz"
        own.save(self.problem, path, packed(self))
        return path


def packed(step: EngineStep) -> dict[str, Array]:
    """The arrays of a file, besides those of the problem."""
    arrays: dict[str, Any] = {"impulse": step.impulse}
    if step.step is not None:
        arrays["step"] = np.array(step.step)
    if step.notes:
        arrays["notes"] = np.frombuffer(json.dumps(dict(step.notes), ensure_ascii=False).encode(), dtype=np.uint8)
    return arrays


def unpacked(problem: FrictionProblem, arrays: Mapping[str, Array]) -> EngineStep:
    """The step in a file's arrays. Errors: InputError naming the array that cannot be used."""
    require("impulse" in arrays, "impulse", "is missing: the file holds a problem, but not what an engine answered")
    require(arrays["impulse"].shape == (problem.contacts, problem.dimension), "impulse", _shape(problem, arrays["impulse"]))
    step = arrays.get("step")
    require(step is None or step.size == 1, "step", "expected a number")
    notes = _text(arrays["notes"]) if "notes" in arrays else {}
    return EngineStep(problem, arrays["impulse"], notes, None if step is None else float(step.item()))


def _shape(problem: FrictionProblem, impulse: Array) -> str:
    return f"expected shape {(problem.contacts, problem.dimension)}, got {impulse.shape}"


def _text(stored: Array) -> Any:
    require(stored.dtype == np.uint8 and stored.ndim == 1 and stored.size <= LARGEST, "notes", "not the bytes of a short text")
    try:
        return json.loads(stored.tobytes().decode())
    except (ValueError, RecursionError):
        raise InputError("notes: not a JSON object in UTF-8") from None


def _checked(notes: Any) -> dict[str, float]:
    require(isinstance(notes, Mapping) and len(notes) <= MOST, "notes", f"expected at most {MOST} names, each with a share")
    for name in notes:
        usable = isinstance(name, str) and 0 < len(name) <= LONGEST and name.isprintable()
        require(usable, "notes", f"a name is a printable text of 1 to {LONGEST} characters, got {name!r:.80}")
    shares = {name: _number("notes", share) for name, share in notes.items()}
    for name, share in shares.items():
        require(0 <= share <= 1, "notes", f"the share of {name} must be from 0 to 1, got {share:g}")
    return shares


def _number(field: str, value: Any) -> float:
    array = check.floats(field, value)
    require(array.ndim == 0 and bool(np.isfinite(array)), field, f"expected a finite number, got {value!r:.80}")
    return float(array)
