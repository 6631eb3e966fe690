"""Solvers in any language: an executable that reads a problem's file and writes its impulses.

    exec:./mysolver {problem} {answer}

is a source of solvers.plugins: a command, in the quoting of a shell, though no shell runs it. {problem} and {answer} stand for
the paths of the two files; a word that names an existing file is made absolute, as the command runs in a temporary folder that
is removed afterwards. docs/executable.md documents both files.

The whole call counts as solve: writing the problem, the process, and reading the answer. A clock of the executable's own is
shown beside it.
"""

import re
import shlex
import shutil
import subprocess
import tempfile
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.check import Array, require
from frictionbench.problems.rows import Rows
from frictionbench.solvers.interface import Answer, Status, solver

PREFIX = "exec:"
FILES = ("{problem}", "{answer}")
ENDED = {"solved": Status.SOLVED, "limit": Status.WORK_LIMIT, "stalled": Status.STALLED, "failed": Status.FAILED}
LONGEST = 2**26  # bytes of an answer


def is_command(source: str) -> bool:
    return source.startswith(PREFIX)


def absolute(source: str) -> str:
    """The source with absolute paths. Errors: InputError where it is no command of an executable with both files."""
    try:
        first, *others = shlex.split(source.removeprefix(PREFIX))
    except ValueError:
        raise InputError(f"solver: {source!r} is no command; write 'exec:./mysolver {{problem}} {{answer}}'") from None
    missing = [name for name in FILES if not any(name in word for word in others)]
    require(not missing, "solver", f"{source!r} lacks {' and '.join(missing)}, which stand for the paths of the files")
    found = shutil.which(first)
    if found is None:
        raise InputError(f"solver: {first} is not an executable file")
    return PREFIX + shlex.join(str(Path(word).absolute()) if Path(word).is_file() else word for word in (found, *others))


def name(source: str) -> str:
    """The solver's name: that of the executable's file."""
    return re.sub(r"[^\w.-]", "_", files(source)[0].name)


def files(source: str) -> list[Path]:
    """The executable and the files among its arguments."""
    return [Path(word) for word in shlex.split(source.removeprefix(PREFIX)) if Path(word).is_file()]


def command_hash(source: str) -> str:
    """The SHA-256 of the command's words, its files by their names alone, as on other machines."""
    words = shlex.split(source.removeprefix(PREFIX))
    return sha256(shlex.join(Path(word).name if Path(word).is_file() else word for word in words).encode()).hexdigest()


def content(source: str) -> str:
    """The SHA-256 of the command and its files. Errors: OSError."""
    parts = [source.encode(), *(path.read_bytes() for path in files(source))]
    return sha256(b"".join(sha256(part).digest() for part in parts)).hexdigest()


@cache
def register(source: str) -> str:
    """Register the command as a solver, once; its name. Errors: InputError where there is another of that name."""
    command = tuple(shlex.split(source.removeprefix(PREFIX)))
    try:
        solver(name(source), family="outside", model="coulomb", dimension=(2, 3), lacks=("asymmetry",))(_solver_class(command))
    except ValueError as error:
        raise InputError(f"solver: {source}: {error}") from None
    return name(source)


def _solver_class(command: tuple[str, ...]) -> type:
    class Executable:
        """A solver that is an executable. (executable)"""

        def form(self, problem: FrictionProblem) -> tuple[FrictionProblem, str]:
            return problem, problem_text(problem)

        def solve(self, formed: Any, tol: float, limit: int | None, start: Array | None = None) -> Answer:
            problem, text = formed
            unit = float(problem.units.min()) if problem.contacts else 1.0
            head = f"tolerance {tol!r}\nvelocity_tolerance {tol * unit!r}\nlimit {limit or 0}\n"
            return _run(command, head + text, (problem.contacts, problem.dimension))

    Executable.__module__ = __name__.rpartition(".")[2]  # not this package's: it is a plug-in
    return Executable


def problem_text(problem: FrictionProblem) -> str:
    """The problem's file after its first lines, tolerances and limit."""
    W, J = problem.W.tocoo(), problem.contact_rows
    d = problem.dimension
    entry, component = np.nonzero(J.value)
    contact = np.repeat(np.arange(problem.contacts), np.diff(J.start))
    sizes = {"dimension": d, "contacts": problem.contacts, "velocities": len(problem.free_velocity)}
    sizes["joints"] = len(problem.joint_bias)
    return "".join(
        [
            *(f"{size} {count}\n" for size, count in sizes.items()),
            _numbers("friction", problem.friction),
            _numbers("friction_bias", problem.friction_bias),
            _entries("W", W.row, W.col, W.data),
            _numbers("q", problem.q),
            _entries("M", *_of_rows(problem.mass_rows)),
            _entries("J", contact[entry] * d + component, J.column[entry], J.value[entry, component]),
            _numbers("v", problem.free_velocity),
            _numbers("offset", problem.offset.ravel()),
            _entries("F", *_of_rows(problem.joint_rows)),
            _numbers("joint_bias", problem.joint_bias),
        ]
    )


def _of_rows(rows: Rows) -> tuple[Any, Any, Array]:
    return np.repeat(np.arange(len(rows.start) - 1), np.diff(rows.start)), rows.column, rows.value


def _entries(field: str, row: Any, column: Any, value: Array) -> str:
    triples = zip(row.tolist(), column.tolist(), value.tolist(), strict=True)
    return f"{field} {len(row)}\n" + "".join(f"{i} {j} {entry!r}\n" for i, j, entry in triples)


def _numbers(field: str, values: Array) -> str:
    return f"{field} {len(values)}\n" + "".join(f"{value!r}\n" for value in values.tolist())


def _run(command: tuple[str, ...], text: str, contacts: tuple[int, int]) -> Answer:
    """Run the command on a problem. Errors: ValueError with the line of the answer that cannot be read."""
    with tempfile.TemporaryDirectory(prefix="frictionbench-exec-") as folder:
        problem, answer, output = (Path(folder) / file for file in ("problem.txt", "answer.txt", "output.txt"))
        problem.write_text(text, encoding="ascii")
        words = [word.replace(FILES[0], str(problem)).replace(FILES[1], str(answer)) for word in command]
        with output.open("wb") as written:
            done = subprocess.run(
                words, cwd=folder, stdin=subprocess.DEVNULL, stdout=written, stderr=subprocess.STDOUT, check=False
            )
        if done.returncode:
            with output.open("rb") as written:
                said = written.read(300).decode("utf-8", "replace").strip()
            detail = f"exit code {done.returncode}" if done.returncode > 0 else f"ended by signal {-done.returncode}"
            return Answer(np.zeros(contacts), Status.FAILED, detail=f"{detail}{f': {said}' if said else ''}")
        if not answer.is_file():
            raise ValueError("answer: the executable wrote no file")
        with answer.open("rb") as read:
            found = read.read(LONGEST + 1)
    if len(found) > LONGEST:
        raise ValueError(f"answer: longer than {LONGEST} bytes")
    return parse_answer(found.decode("utf-8", "replace"), contacts)


def parse_answer(text: str, contacts: tuple[int, int]) -> Answer:
    """The answer in a file's text. Errors: ValueError with the line that cannot be read."""
    lines = iter(enumerate(text.splitlines(), start=1))
    facts: dict[str, str] = {}
    for at, line in lines:
        words = line.split()
        if words == ["impulse"]:
            break
        if len(words) != 2 or words[0] in facts:
            raise ValueError(f"answer: line {at}: expected a new name and its value, or impulse, got {line[:40]!r}")
        facts[words[0]] = words[1]
    else:
        raise ValueError("answer: it has no line impulse")
    status = facts.pop("status", None)
    if status not in ENDED:
        raise ValueError(f"answer: status must be {', '.join(ENDED)}, got {status!r:.40}")
    try:
        clock = facts.pop("clock", None)
        seconds = None if clock is None else float(clock)
        work = {unit: int(count) for unit, count in facts.items()}
        impulse = np.array([float(word) for _, line in lines for word in line.split()])
    except ValueError as error:
        raise ValueError(f"answer: {error}") from None
    shaped = impulse.reshape(contacts) if impulse.size == contacts[0] * contacts[1] else impulse
    return Answer(shaped, ENDED[status], work, clock=seconds)
