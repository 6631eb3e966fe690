"""The stored problems of a run: DIR/problems/HASH.npz, with a reference answer, starts, and a list of records for each source.

A folder may come from someone else: each record is checked when it is read, and problems and starts are compared with hashes.
"""

from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Json

from frictionbench.problems import LCP, FrictionProblem, InputError
from frictionbench.problems.check import Array, require
from frictionbench.problems.recorded.archive import read_arrays
from frictionbench.problems.recorded.native import load
from frictionbench.results.conventions import COLD
from frictionbench.results.files import ResultsError, parsed, read_json
from frictionbench.results.schema import PROBLEM_FACTS

Record = dict[str, Any]  # the facts of a stored problem: PROBLEM_FACTS, starts and repeats


@dataclass
class _Stored:
    """The fields of a stored record that are checked, since they name files or become columns."""

    problem: Annotated[str, Field(pattern="^[0-9a-f]{8,64}$")]
    scene: str
    parameters: Json[dict[str, Any]]
    step: Annotated[int, Field(strict=True, ge=0, lt=10**9)]
    phase: str
    contacts: Annotated[int | None, Field(strict=True)]
    starts: dict[Literal["cold", "warm", "shuffled"], str]


def read_records(path: Path) -> list[Record]:
    """Read the records in a file written by `collect`. Errors: ResultsError naming the file if it is another or damaged."""
    records = read_json(path)
    parsed(records, Annotated[list[_Stored], Field(min_length=1)], path)  # type: ignore[arg-type]
    if not all(record.keys() >= {*PROBLEM_FACTS} and list(record["starts"])[:1] == [COLD] for record in records):
        raise ResultsError(f"{path}: not a list of problems")
    return records


def stored(folder: Path, problem: str) -> FrictionProblem | LCP:
    """Read a stored problem by its hash. Errors: InputError if the file is missing, damaged or holds another problem."""
    path = folder / "problems" / f"{problem}.npz"
    loaded = load(path)
    require(loaded.hash == problem, str(path), f"holds another problem, {loaded.hash}, than the one its name is the hash of")
    return loaded


def stored_friction(folder: Path, problem: str) -> FrictionProblem:
    """Read a stored friction problem by its hash. Errors: InputError as for `stored`, and if it is a bare LCP."""
    loaded = stored(folder, problem)
    if isinstance(loaded, LCP):
        raise InputError(f"problem: {problem} is a bare LCP, without contacts")
    return loaded


def stored_answer(folder: Path, problem: str) -> Array | None:
    """Read the refined reference answer (nc, d) of a stored problem; None if there is none that can be read."""
    with suppress(InputError, KeyError):
        return read_arrays(answer_file(folder, problem))["impulse"]
    return None


def answer_file(folder: Path, problem: str) -> Path:
    """Return the path of a stored problem's reference answer."""
    return folder / "problems" / f"{problem}.answer.npz"


def stored_start(folder: Path, problem: str, source_origin: str, start: str, digest: str = "") -> Array | None:
    """Read the impulses (nc, d) of a start of a stored problem; None for a cold start.

    source_origin: see plan.origin. digest: the expected hash, not compared if empty. Errors: InputError naming the file.
    """
    if start == COLD:
        return None
    path = starts_file(folder, problem, source_origin)
    try:
        impulses = read_arrays(path)[start]
    except (InputError, KeyError):
        raise InputError(f"{path}: the start {start} cannot be read: the file is missing or damaged") from None
    same = not digest or digest_of(impulses) == digest
    require(same, str(path), f"holds another start {start} than the one that was collected")
    return impulses


def digest_of(impulses: Array) -> str:
    """Return the hash by which a start's impulses are recognised."""
    return sha256(repr(impulses.shape).encode() + np.ascontiguousarray(impulses, float).tobytes()).hexdigest()


def starts_file(folder: Path, problem: str, source_origin: str) -> Path:
    """Return the path of the starts of a stored problem, which depend on its origin."""
    return folder / "problems" / f"{problem}.{sha256(source_origin.encode()).hexdigest()[:8]}.starts.npz"


def files_of(folder: Path, problem: str, source_origin: str) -> list[Path]:
    """Return the existing files of a stored problem, without listing the folder, which may hold very many."""
    problem_file, answer = folder / "problems" / f"{problem}.npz", answer_file(folder, problem)
    return [path for path in (problem_file, answer, starts_file(folder, problem, source_origin)) if path.exists()]
