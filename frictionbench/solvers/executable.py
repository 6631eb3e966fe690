"""Solvers in any language: an executable that reads a problem's file and writes its impulses.

    exec:./mysolver {problem} {answer}

is a source of solvers.plugins: a command, quoted as for a shell, though no shell runs it. {problem} and {answer} stand for the
paths of the two files. A word that names an existing file is made absolute, because the command runs in a temporary folder,
which is removed afterwards. docs/executable.md documents both files.

The step form makes the text of the problem; writing it, the process, and reading the answer are part of solve.
"""

import errno
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
from frictionbench.problems.rows import row_of_entry
from frictionbench.solvers.interface import Answer, Status, solver

PREFIX, COMMAND = "exec:", "command"  # of a source; name of its command among the contents that a run records
FILES = ("{problem}", "{answer}")
ENDED = {"solved": Status.SOLVED, "limit": Status.WORK_LIMIT, "stalled": Status.STALLED, "failed": Status.FAILED}
LARGEST_ANSWER = 2**26  # bytes of an answer


def is_command(source: str) -> bool:
    return source.startswith(PREFIX)


def absolute(source: str) -> str:
    """The source with absolute paths. Errors: InputError if it is not a command of an executable with both files."""
    try:
        first, *others = shlex.split(source.removeprefix(PREFIX))
    except ValueError:
        raise InputError(f"solver: {source!r} is no command; write 'exec:./mysolver {{problem}} {{answer}}'") from None
    missing = [name for name in FILES if not any(name in word for word in others)]
    require(not missing, "solver", f"{source!r} lacks {' and '.join(missing)}, in whose place paths of files are put")
    program = shutil.which(first)
    if program is None:
        hint = ("; write ./" if shutil.which(f"./{first}") else "; chmod +x ") + first if Path(first).is_file() else ""
        raise InputError(f"solver: {first} is not an executable file{hint}")
    return PREFIX + shlex.join(str(Path(word).absolute()) if Path(word).is_file() else word for word in (program, *others))


def files(source: str) -> list[Path]:
    """The executable and the files among its arguments."""
    return [Path(word) for word in shlex.split(source.removeprefix(PREFIX)) if Path(word).is_file()]


def command_hash(source: str) -> str:
    """The SHA-256 of the command with its files reduced to their names, so that it is the same on all machines."""
    words = shlex.split(source.removeprefix(PREFIX))
    return sha256(shlex.join(Path(word).name if Path(word).is_file() else word for word in words).encode()).hexdigest()


def content(source: str) -> str:
    """The SHA-256 of the command and its files. Errors: OSError."""
    parts = [source.encode(), *(path.read_bytes() for path in files(source))]
    return sha256(b"".join(sha256(part).digest() for part in parts)).hexdigest()


@cache
def register(source: str) -> str:
    """Register the command as a solver, once; return its name, that of its file. Errors: InputError if the name is taken."""
    command, name = tuple(shlex.split(source.removeprefix(PREFIX))), re.sub(r"[^\w.-]", "_", files(source)[0].name)

    class Executable:
        """A solver that is an executable. (executable)"""

        def form(self, problem: FrictionProblem) -> tuple[FrictionProblem, str]:
            return problem, problem_text(problem)

        def solve(self, formed: Any, tol: float, limit: int | None, start: Array | None = None) -> Answer:
            problem, text = formed
            unit = float(problem.units.min()) if problem.contacts else 1.0
            head = f"tolerance {tol!r}\nvelocity_tolerance {tol * unit!r}\nlimit {limit or 0}\n"
            return _run(command, head + text, (problem.contacts, problem.dimension))

    Executable.__module__ = __name__.rpartition(".")[2]  # outside this package: it is a plug-in
    try:
        solver(name, family="outside", model="coulomb", dimension=(2, 3), lacks=("asymmetry",))(Executable)
    except ValueError as error:
        raise InputError(f"solver: {source}: {error}") from None
    return name


def problem_text(problem: FrictionProblem) -> str:
    """The text of the problem's file after its first lines, which hold the tolerances and the limit."""
    W, J, M, F, d = problem.W.tocoo(), problem.contact_rows, problem.mass_rows, problem.joint_rows, problem.dimension
    entry, component = np.nonzero(J.value)
    sizes = (d, problem.contacts, len(problem.free_velocity), len(problem.joint_bias))
    columns: dict[str, tuple[Any, ...]] = {
        "friction": (problem.friction,),
        "friction_bias": (problem.friction_bias,),
        "W": (W.row, W.col, W.data),
        "q": (problem.q,),
        "M": (row_of_entry(M.start), M.column, M.value),
        "J": (row_of_entry(J.start)[entry] * d + component, J.column[entry], J.value[entry, component]),
        "v": (problem.free_velocity,),
        "offset": (problem.offset.ravel(),),
        "F": (row_of_entry(F.start), F.column, F.value),
        "joint_bias": (problem.joint_bias,),
    }
    text = "dimension {}\ncontacts {}\nvelocities {}\njoints {}\n".format(*sizes)
    for field, parts in columns.items():
        lines = zip(*(part.tolist() for part in parts), strict=True)
        text += f"{field} {len(parts[0])}\n" + "".join(" ".join(map(repr, line)) + "\n" for line in lines)
    return text


def _run(command: tuple[str, ...], text: str, contacts: tuple[int, int]) -> Answer:
    """Run the command on a problem. Errors: ValueError with the line of the answer that cannot be read."""
    with tempfile.TemporaryDirectory(prefix="frictionbench-exec-") as folder:
        problem, answer, output = (Path(folder) / file for file in ("problem.txt", "answer.txt", "output.txt"))
        problem.write_text(text, encoding="ascii")
        words = [word.replace(FILES[0], str(problem)).replace(FILES[1], str(answer)) for word in command]
        with output.open("wb") as written:
            try:
                done = subprocess.run(
                    words, cwd=folder, stdin=subprocess.DEVNULL, stdout=written, stderr=subprocess.STDOUT, check=False
                )
            except OSError as error:
                why = {errno.ENOEXEC: " (a script needs a first line #!)", errno.ENOENT: " (or what its #! names)"}
                raise ValueError(f"{words[0]}: {error.strerror}{why.get(error.errno or 0, '')}") from None
        if done.returncode:
            with output.open("rb") as written:
                output_text = written.read(300).decode("utf-8", "replace").strip()
            detail = f"exit code {done.returncode}" if done.returncode > 0 else f"ended by signal {-done.returncode}"
            return Answer(np.zeros(contacts), Status.FAILED, detail=f"{detail}{f': {output_text}' if output_text else ''}")
        if not answer.is_file():
            raise ValueError("answer: the executable wrote no file")
        with answer.open("rb") as read:
            content = read.read(LARGEST_ANSWER + 1)
    if len(content) > LARGEST_ANSWER:
        raise ValueError(f"answer: longer than {LARGEST_ANSWER} bytes")
    return parse_answer(content.decode("utf-8", "replace"), contacts)


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
        seconds = float(facts.pop("clock")) if "clock" in facts else None
        work = {unit: int(count) for unit, count in facts.items()}
        impulse = np.array([float(word) for _, line in lines for word in line.split()])
    except ValueError as error:
        raise ValueError(f"answer: {error}") from None
    shaped = impulse.reshape(contacts) if impulse.size == contacts[0] * contacts[1] else impulse
    return Answer(shaped, ENDED[status], work, clock=seconds)
