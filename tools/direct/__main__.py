"""The time charged to an adapter, form + setup + solve, over the wall time of calling its library by hand (tools.direct.calls).

    python -m tools.direct [SOLVER ...] [--data DIR]      tables in Markdown, of all libraries or of the solvers named

The samples are pushed stacks and random bodies of 2 to 300 contacts at 1e-8 and, with --data, a folder's recorded problems.
Each adapter and its call by hand are timed alternately, so that other load affects both; the least of REPEATS calls counts, or
of as many as take SECONDS. For a library in another process, setup and solve are measured by its own clock on both sides. A
call by hand whose answer is a near miss is asked for a tenth, then a hundredth, of the tolerance, for the times to be those of
equal accuracy. If the ratio is above FAIR, the adapter's docstring says why, under Charged. Verdicts other than solved or
relaxed are shown after the times, for the adapter's answer and for the one by hand.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np

import frictionbench as fb
from frictionbench.problems import FrictionProblem
from frictionbench.solvers import Answer, Status, find
from tools.direct.arrays import Called, arrays
from tools.direct.calls import CALLS
from tools.direct.page import facts

BLOCKS, BODIES = (1, 10, 50, 150), (20, 100, 300)  # blocks in planar stacks, with two contacts each; contacts in space
LINKS = {"chain": (20, 40), "rod_chain": (20, 100)}  # falling links with two contacts each, in the plane and in space
TOL, REPEATS, SECONDS, FAIR = 1e-8, 15, 3.0, 1.3
CHILDS_CALLS = 20  # of the adapter in a row, and forms: the first find empty caches, after the process of the call by hand


class Charged(NamedTuple):
    """Seconds by hand, with the adapter, and by the library's own clock, if any; the two verdicts; the tolerance by hand."""

    by_hand: float
    adapter: float
    clock: float | None
    verdicts: tuple[str, str]
    asked: float

    def __str__(self) -> str:
        own = "none" if self.clock is None else f"{1e6 * self.clock:.0f}"
        verdicts = "" if self.good == (True, True) else f" ({self.verdicts[0]}, by hand {self.verdicts[1]})"
        asked = "" if self.asked == TOL else f" (by hand at {self.asked:.0e})"
        return f"{1e6 * self.by_hand:.0f}, {1e6 * self.adapter:.0f}, {own}; {self.ratio:.2f}{asked}{verdicts}"

    @property
    def ratio(self) -> float:
        return self.adapter / self.by_hand

    @property
    def good(self) -> tuple[bool, ...]:
        """Return whether the adapter's answer and the one by hand are solved or relaxed."""
        return tuple(verdict in ("solved", "relaxed") for verdict in self.verdicts)


def charged_tables(solvers: list[str]) -> Iterator[str]:
    """Yield the lines of the tables in the plane and in space, without and with joint equations, a row for each library that
    takes them or named solver. One that is not installed has the reason.

    Errors: InputError if a named solver has no call by hand.
    """
    specs = chosen(solvers)
    stacks = [fb.scene("stack", blocks=blocks, push=1.0).problem() for blocks in BLOCKS]
    yield from _table(specs, stacks)
    yield ""
    yield from _table(specs, [fb.instance("random_bodies", contacts=contacts, seed=2) for contacts in BODIES])
    for name, lengths in LINKS.items():
        yield ""
        yield from _table(specs, [fb.problem(name, links=links, fall=1) for links in lengths])


def _table(specs: list[str], problems: list[FrictionProblem]) -> Iterator[str]:
    d, joints = problems[0].dimension, len(problems[0].joint_bias)
    heads = [f"{problem.summary}: µs by hand, charged, own clock; ratio" for problem in problems]
    yield _row("", *heads, f"why more than {FAIR}")
    yield _row(*["---"] * (len(heads) + 2))
    for spec in specs:
        info, _ = find(spec)
        call = CALLS[spec]
        if d not in call.d or (joints and (call.by_matrix or not call.joints or info.refuses(problems[0]))):
            continue
        if info.missing:
            yield _row(spec, info.missing, *[""] * len(heads))
            continue
        measured = [charged(spec, problem) for problem in problems if problem.contacts <= call.most]
        why = facts(info).get("Charged", "") if max(each.ratio for each in measured) > FAIR else ""
        yield _row(spec, *map(str, measured), *["–"] * (len(problems) - len(measured)), why)


def recorded_table(solvers: list[str], folder: Path) -> Iterator[str]:
    """Yield the lines of the table on the recorded problems of a folder, for calls that accept problems given by W and q.

    Errors: InputError as for charged_tables, or if the folder has no friction problem.
    """
    problems = {path.name: fb.load(path) for path in sorted(folder.iterdir()) if path.is_file()}
    ordinary = {name: p for name, p in problems.items() if isinstance(p, FrictionProblem) and not p.friction_bias.any()}
    if not ordinary:
        raise fb.InputError(f"data: no friction problem in {folder}")
    yield _row("recorded", "problems", "adapter solves", "by hand", "ratio: geometric mean", "worst", "of")
    yield _row(*["---"] * 7)
    for spec in chosen(solvers):
        call, (info, _) = CALLS[spec], find(spec)
        taken = {
            name: problem
            for name, problem in ordinary.items()
            if call.by_matrix and problem.dimension in call.d and problem.contacts <= call.most and not info.refuses(problem)
        }
        if info.missing or not taken:
            continue
        found = {
            name: charged(spec, FrictionProblem.from_delassus(p.W, p.q, p.friction, p.dimension)) for name, p in taken.items()
        }
        both = {name: each.ratio for name, each in found.items() if each.good == (True, True)}
        solved = [sum(each.good[side] for each in found.values()) for side in (0, 1)]
        mean, worst = np.exp(np.mean(np.log(list(both.values())))), max(both, key=both.__getitem__)
        yield _row(spec, str(len(taken)), *map(str, solved), f"{mean:.2f}", f"{both[worst]:.2f}", worst)


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def chosen(solvers: list[str]) -> list[str]:
    """Return the calls by hand of the named solvers, all if none is named. Errors: InputError if a named one has none."""
    known = {name for spec in CALLS for name in (spec, spec.partition("[")[0])}
    if unknown := [name for name in solvers if name not in known]:
        raise fb.InputError(f"solver: {unknown[0]!r} has no call by hand; there are {', '.join(CALLS)}")
    return [spec for spec in CALLS if not solvers or {spec, spec.partition("[")[0]} & set(solvers)]


def charged(spec: str, problem: FrictionProblem) -> Charged:
    """Time a call by hand and the adapter alternately."""
    _, solver = find(spec)
    by_arrays, by_hand, adapter, clock = arrays(problem), float("inf"), float("inf"), None
    for asked in (TOL, TOL / 10, TOL / 100):  # the first calls include loading and compiling
        if _verdict(spec, problem, CALLS[spec].function(by_arrays, asked)) != "near_miss":
            break
    solver.solve(solver.prepare(problem.fresh()), TOL, None)
    until = perf_counter() + SECONDS
    for _ in range(REPEATS):
        begun = perf_counter()
        called = CALLS[spec].function(by_arrays, asked)
        by_hand = min(by_hand, perf_counter() - begun if called.clock is None else called.clock)
        forming, solving, calls = float("inf"), float("inf"), 1 if called.clock is None else CHILDS_CALLS
        for fresh in [problem.fresh() for _ in range(calls)]:
            start = perf_counter()
            formed = solver.form(fresh)
            forming = min(forming, perf_counter() - start)
        for _ in range(calls):
            start = perf_counter()
            answer = solver.solve(solver.setup(formed), TOL, None)
            solving = min(solving, perf_counter() - start if called.clock is None else answer.clock or 0.0)
            clock = clock if answer.clock is None else min(clock or float("inf"), answer.clock)
        adapter = min(adapter, forming + solving)
        if perf_counter() > until:
            break
    one = fb.verify(problem, answer, TOL, solver=spec).verdict.value
    return Charged(by_hand, adapter, clock, (one, _verdict(spec, problem, called)), asked)


def _verdict(spec: str, problem: FrictionProblem, called: Called) -> str:
    """Return the verdict on an answer by hand."""
    answer = Answer(called.impulse, Status.SOLVED if called.claimed else Status.FAILED, softness=called.softness)
    return fb.verify(problem, answer, TOL, solver=spec).verdict.value


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("solvers", nargs="*", metavar="SOLVER")
    parser.add_argument("--data", type=Path, metavar="DIR")
    asked = parser.parse_args()
    try:
        for line in recorded_table(asked.solvers, asked.data) if asked.data else charged_tables(asked.solvers):
            print(line, flush=True)
    except fb.InputError as error:
        sys.exit(str(error))
