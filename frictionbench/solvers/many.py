"""Solving many problems: a method's compiled loop over packed problems, in threads, and the residual of every answer.

A solver with a method `solve_many` (solvers.interface) receives all problems of one dimension as arrays. Problems with joints,
and those to which it gives the status None, such as problems with islands of unlike speeds (solvers.balanced), are solved one
by one. A compiled loop does not hold the interpreter's lock (problems.compiled.loop), so that threads can share the problems.
The functions at the end are common to these loops: the problems they skip, the place of the impulses, and the results.
"""

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.check import Array, count, require
from frictionbench.problems.compiled import inlined, kernel, lean
from frictionbench.problems.packed import CONTACT, Batch, Packed, residuals
from frictionbench.problems.residual import residual_with_floor
from frictionbench.problems.rows import Index64
from frictionbench.solvers.balanced import UNLIKE
from frictionbench.solvers.interface import (
    Solved,
    Solver,
    SolverInfo,
    Status,
    find,
    impulses,
    solve,
    tolerance,
    why_lost,
    work_limit,
)

ALONE = -1  # how a problem ends that the loop does not solve: it is solved by itself
CHUNKS = 8  # shares for each worker: enough to end at about the same time, few enough to make the cost of a call negligible


@dataclass(frozen=True, eq=False, repr=False)
class Answers:
    """The results of `solve_many` for N problems; answers[k] is the impulse (nc, d) of problem k.

    impulse: flat, of all problems; those of problem k are impulse[first[k]:first[k + 1]]. first: (N+1,).
    status: (N,), each a Status, as the solver claims. work: its counts, (N,) by name.
    residual: (N,), of the exact problem (problems.residual), from the impulses. floor: (N,), what rounding may add to it.
    tol: the requested residual. Errors: IndexError for answers[k] if there is no problem k.

    >>> import frictionbench as fb
    >>> answers = fb.solve_many([fb.scene("stack", blocks=n, push=1.0).problem() for n in (1, 2)], "lemke")
    >>> answers, answers[1].shape, sorted(answers.work)
    (Answers(2 problems, 2 within 1e-08), (4, 2), ['inversions', 'pivots', 'restarts'])
    """

    impulse: Array
    first: Index64
    dimension: Index64
    status: NDArray[np.object_]
    work: dict[str, Index64]
    residual: Array
    floor: Array
    tol: float

    @property
    def solved(self) -> NDArray[np.bool_]:
        """(N,): whether the residual is within tol, whatever the solver claims."""
        return self.residual <= self.tol

    def __len__(self) -> int:
        return len(self.status)

    def __getitem__(self, k: int) -> Array:
        if not (isinstance(k, int | np.integer) and -len(self) <= k < len(self)):
            raise IndexError(f"answers[k]: {k!r} is not the number of one of {len(self)} problems")
        k = range(len(self))[k]
        return self.impulse[self.first[k] : self.first[k + 1]].reshape(-1, self.dimension[k])

    def __repr__(self) -> str:
        return f"Answers({len(self)} problems, {int(self.solved.sum())} within {self.tol:g})"


def solve_many(
    problems: Batch | Iterable[FrictionProblem],
    solver: str = "hybrid",
    *,
    tol: float = 1e-8,
    limit: int | None = None,
    start: Array | Answers | Sequence[Array] | None = None,
    workers: int = 1,
) -> Answers:
    """Solve many friction problems with one solver: the same impulses as by `solve`, to the last bit, in less time for each.

    problems: FrictionProblems of any sizes, or a Batch of them, which is already packed.
    solver, tol, limit: as in `solve`. workers: the number of threads, among which the problems are divided.
    start: guesses of the impulses, N s: an array (nc, d) for each problem, Answers, or their flat `impulse`. A solver without
        warm start ignores them.

    Some solvers process all problems in compiled code (lemke, nsgs, the first phase of interior_point and the first two members
    of hybrid). With others, problems with joints and those that the compiled code does not solve are given to `solve` one by
    one, which threads do not make faster.

    Returns Answers: the impulses, statuses and counts as arrays, and each answer's residual on the exact problem.
    Errors: InputError as for `solve`, with the number of the problem that the solver does not take, or of its start.

    >>> import frictionbench as fb
    >>> problems = [fb.scene("stack", blocks=1, push=push).problem() for push in (0.5, 1.0, 2.0)]
    >>> answers = fb.solve_many(problems, "lemke")
    >>> answers.solved.tolist(), answers[1].shape
    ([True, True, True], (2, 2))
    >>> warm = fb.solve_many(problems, "lemke", start=answers)
    >>> warm.work["pivots"].tolist(), min(answers.work["pivots"].tolist()) > 0
    ([0, 0, 0], True)
    """
    info, instance = find(solver)
    tol, limit = tolerance(tol), work_limit(limit)
    workers = count("workers", workers)
    batch = problems if isinstance(problems, Batch) else Batch(problems)
    _require_taken(info, batch)
    begin = None if start is None else _flat(start, batch)
    begin = begin if info.warm_start else None
    flat, residual, floor = np.zeros(batch.first[-1]), *np.empty((2, len(batch)))
    answers = Answers(flat, batch.first, batch.dimension, np.full(len(batch), None), {}, residual, floor, tol)
    if hasattr(instance, "solve_many"):
        for numbers, packed in batch.groups:
            places = _places(answers, numbers, packed)
            guess = None if begin is None else begin[places].reshape(-1, packed.dimension)
            _fill(answers, numbers, places, *_looped(instance, packed, tol, limit, guess, workers))
    for k in np.flatnonzero(answers.floor > tol).tolist() if info.ours else ():
        if answers.status[k] is Status.SOLVED:
            answers.status[k] = Status.ROUNDING
    for k in np.flatnonzero(answers.status != Status.SOLVED).tolist():
        if answers.status[k] is None:
            _solve_alone(answers, k, batch.problems[k], solver, limit, begin)
        elif why_lost(info, batch.problems[k], answers.status[k], tol):
            answers.status[k] = Status.INFEASIBLE
    return answers


def _require_taken(info: SolverInfo, batch: Batch) -> None:
    """Errors: InputError naming the first problem that the solver does not take."""
    require(not info.missing, "solver", str(info.missing))
    alike = not info.lacks and set(info.dimension) == {2, 3}
    for k, problem in () if alike else enumerate(batch):
        reason = info.refuses(problem)
        require(reason is None, f"problems[{k}]", str(reason))


def _flat(start: Any, batch: Batch) -> Array:
    """A checked copy of the impulses of all problems as a flat array. Errors: InputError naming start or its entry."""
    flat = isinstance(start, np.ndarray) and start.ndim == 1 and start.dtype != object
    known = flat or isinstance(start, Answers | Sequence | np.ndarray)
    require(known, "start", f"must be impulses of each problem, got {type(start)}")
    require(flat or len(start) == len(batch), "start", f"expected impulses of {len(batch)} problems, got {len(start)}")
    if flat or isinstance(start, Answers):
        return impulses(start if flat else start.impulse, (int(batch.first[-1]),))
    parts = [np.zeros(0)]
    for k, (impulse, problem) in enumerate(zip(start, batch, strict=True)):
        require(impulse is not None, f"start[{k}]", "must be impulses, got None")
        try:
            parts.append(impulses(impulse, (problem.contacts, problem.dimension)).ravel())
        except InputError as error:
            raise InputError(f"start[{k}]{str(error).removeprefix('start')}") from None
    return np.concatenate(parts)


def _looped(
    instance: Solver, packed: Packed, tol: float, limit: int | None, start: Array | None, workers: int
) -> tuple[Solved, Array]:
    """The results of the solver's own loop, and the residuals with their floors (N, 2). start: (contacts, d), or None."""

    def part(share: Packed, begin: int = 0) -> tuple[Solved, Array]:
        guess = () if start is None else (start[begin : begin + int(share.contacts[-1])],)
        solved = instance.solve_many(share, tol, limit, *guess)  # type: ignore[attr-defined]
        impulse, expected = np.ascontiguousarray(solved.impulse, float), (int(share.contacts[-1]), share.dimension)
        require(impulse.shape == expected, "solve_many", f"must return impulses of shape {expected}, got {impulse.shape}")
        return solved, residuals(share, impulse)

    if workers == 1:
        return part(packed)
    ends = np.unique(np.linspace(0, packed.size, min(packed.size, CHUNKS * workers) + 1).astype(int)).tolist()
    with ThreadPoolExecutor(workers) as pool:
        shares = [packed.part(*ends[i : i + 2]) for i in range(len(ends) - 1)]
        parts = list(pool.map(part, shares, packed.contacts[ends].tolist()))
    solved = [each for each, _ in parts]
    names = dict.fromkeys(name for each in solved for name in each.work)  # a share may lack counts of others
    work = {
        name: np.concatenate([each.work.get(name, np.zeros(len(each.status), np.int64)) for each in solved]) for name in names
    }
    joined = Solved(np.concatenate([each.impulse for each in solved]), np.concatenate([each.status for each in solved]), work)
    return joined, np.concatenate([checked for _, checked in parts])


def _places(answers: Answers, numbers: Index64, packed: Packed) -> Index64 | slice:
    """The places of the packed problems' impulses among those of all problems; numbers: of the packed problems."""
    if len(numbers) == len(answers):
        return slice(None)
    begin = packed.contacts * packed.dimension
    return np.arange(begin[-1]) + np.repeat(answers.first[numbers] - begin[:-1], np.diff(begin))


def _fill(answers: Answers, numbers: Index64, places: Index64 | slice, solved: Solved, checked: Array) -> None:
    """Write the results of the problems with these numbers to their places."""
    answers.impulse[places] = solved.impulse.ravel()
    answers.status[numbers] = solved.status
    answers.residual[numbers], answers.floor[numbers] = checked.T
    for name, counts in solved.work.items():
        answers.work.setdefault(name, np.zeros(len(answers), np.int64))[numbers] = counts


def _solve_alone(answers: Answers, k: int, problem: FrictionProblem, spec: str, limit: int | None, start: Array | None) -> None:
    contacts = slice(answers.first[k], answers.first[k + 1])
    guess = None if start is None else start[contacts].reshape(-1, problem.dimension)
    answer: Any = solve(problem, spec, tol=answers.tol, limit=limit, start=guess)
    answers.impulse[contacts] = np.ravel(answer.impulse)
    answers.status[k] = answer.status
    answers.residual[k], answers.floor[k] = residual_with_floor(problem, answers[k])
    for name, value in answer.work.items():
        answers.work.setdefault(name, np.zeros(len(answers), np.int64))[k] = value


@kernel
def unsolved(packed, counts):  # type: ignore[no-untyped-def]
    """The initial results of a loop: impulses (contacts, d) of zeros, ALONE (N,), and counts (N, counts) of zeros."""
    count = len(packed.first) - 1
    contacts = packed.first[count, CONTACT] - packed.first[0, CONTACT]
    return np.zeros((contacts, packed.J.shape[1])), np.full(count, ALONE), np.zeros((count, counts), np.int64)


@lean
def is_alone(packed, k):  # type: ignore[no-untyped-def]
    """Whether problem k must be solved by itself, because its islands have unlike speeds."""
    return packed.spread[k] > UNLIKE


@inlined
def impulses_of(packed, k, r):  # type: ignore[no-untyped-def]
    """The impulses of problem k, as a view of those of all problems (contacts, d)."""
    begin = packed.first[0, CONTACT]
    return r[packed.first[k, CONTACT] - begin : packed.first[k + 1, CONTACT] - begin]


def solved(r: Array, ended: Index64, statuses: Sequence[Status], work: Index64, names: tuple[str, ...]) -> Solved:
    """The results of a loop. statuses: by how a problem ended, other than ALONE. work: the counts (N, names)."""
    by_number = np.array([*statuses, None])
    return Solved(r, by_number[ended], dict(zip(names, work.T, strict=True)))
