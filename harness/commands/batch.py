"""`frictionbench batch`: the rates of `solve_many` on thousands of small problems, beside single calls and other libraries.

    python -m frictionbench.harness.commands.batch > docs/performance.md      # all sizes, and large problems

At each size the problems are stacks of as many contacts, of boxes in the plane and of cubes in space, each with its own push,
friction and mass ratio. All ways of solving them are timed in turn, ROUNDS times, by the processor's time, which another
process on the core does not change, and the least time counts; threads by the wall's. Rates are relative to single calls of
lemke, in space of hybrid, on the same problems in the same run. A rate is refused where it says nothing: without contacts,
where friction is idle in all problems, and where a residual is above TOL; that of threads, on as many problems as take
LONG seconds, where the machine's load was above QUIET beforehand.
"""

import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numba import njit

from frictionbench.harness.commands import large, members, seeds
from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.analysis.frictionless import idle
from frictionbench.problems.batch import Batch
from frictionbench.problems.check import Array, require
from frictionbench.problems.forms.lcp import tangent_basis
from frictionbench.problems.instances import make_instance
from frictionbench.problems.packed import residuals
from frictionbench.solvers import Status, available, solve, solve_many
from frictionbench.solvers.interface import find
from frictionbench.solvers.loops import impulses_of
from frictionbench.solvers.outside.quantecon import kernel_of
from frictionbench.solvers.pivots.dense_lcp import dense_lcp
from frictionbench.solvers.pivots.packed_lcp import lcp_space, scaled_lcp_of, write_stretched

# By the contacts' dimension: problems of so many contacts, some hundredths of a second each; the methods with a loop; single
# calls of which method the rates are relative to.
SIZES = {2: {2: 500, 4: 300, 10: 150, 20: 60, 40: 20}, 3: {4: 100, 12: 30, 40: 10}}
LOOPED = {
    2: ("lemke", "dantzig", "path_search", "nsgs", "interior_point", "hybrid"),
    3: ("nsgs", "interior_point", "hybrid"),
}
BASE = {2: "lemke", 3: "hybrid"}
ALONE = ("osqp", "daqp")  # one by one: their loop is Python's
TOL, ROUNDS, SAMPLE, AGAIN, SEED = 1e-8, 5, 20, 10, 1
SHORT, LONG = 0.01, 0.5  # s: in shorter runs a call's own time counts, and that of starting threads
COLUMNS = (
    "dimension",
    "contacts",
    "active",
    "idle",
    "way",
    "problems_per_second",
    "ratio",
    "verified",
    "p50",
    "p95",
    "worst",
    "threads",
)
QUIET = 0.5  # processes that wait for a core, by the system's mean over a minute
HEAD = """# Performance

## By the thousand

Made by `python -m frictionbench.harness.commands.batch`. Problems a second in a loop over stacks, each with its own push (0.2
to 2 m/s), friction (0.2 to 0.8) and mass ratio (1 to 10), **relative to single calls of `solve(problem, "lemke")`**, in space
of `solve(problem, "hybrid")`, on the same problems in the same run; processor's time, least of {rounds} rounds in turn.
*packed* is `solve_many` over a `Batch`, form, solve and the residual of every answer included; *with packing* over a list of
problems. *p50*, *p95* and *worst* are the times of a problem in the packed loop, of {sample} problems repeated at least
{again} times each, over the mean time of such a single call. *threads* is the rate of the packed loop on {workers} cores over
that on one, by the wall's clock, on the problems repeated for half a second; *busy* where other processes ran. The compiled
loop of quantecon is its own kernel called from compiled code, on dense matrices made beforehand: without form and residuals,
which ours include. *quantecon, our form and residuals* is the same kernel with our form before it and our residuals after it,
like *lemke, packed*, so that kernels alone differ. Both take ratios within 1e-10 as ties, its tuned setting. osqp and daqp
solve the convex relaxation. Compiling and loading kernels is in no figure; all starts are cold, from zero impulses.

A rate is shown only where every residual is within 1e-8; otherwise the share that is.
"""


@dataclass(frozen=True)
class Case:
    """Problems of one size. active: the share of contacts that bear. idle: of problems without need of friction, by SAMPLE of
    them."""

    contacts: int
    dimension: int
    problems: tuple[FrictionProblem, ...]
    active: float
    idle: float


@dataclass(frozen=True)
class Way:
    """A way to solve the problems of a batch: run is timed, impulses turns what it returns into those of all problems, flat."""

    batch: Batch
    run: Callable[[], Array]
    impulses: Callable[[Array], Array] = np.asarray


@dataclass(frozen=True)
class Rate:
    """Of one way to solve a case: how often as many problems a second as single calls of BASE, and the share verified."""

    way: str
    ratio: float
    verified: float
    percentiles: tuple[float, float, float] | None = None
    threads: float | None = None
    per_second: float = 0.0


def refusal(case: Case, rate: Rate) -> str:
    """Why a rate says nothing; empty where it does."""
    if not case.contacts:
        return "no contacts"
    if case.idle == 1 or not case.active:
        return "friction is idle in all problems"
    return "" if rate.verified == 1 else f"{100 * rate.verified:.0f} % verified"


def make_case(dimension: int, contacts: int, count: int) -> Case:
    """So many stacks of as many contacts, from SEED."""
    rng = np.random.default_rng([SEED, contacts])
    settings = [
        {"push": rng.uniform(0.2, 2), "friction": rng.uniform(0.2, 0.8), "mass_ratio": rng.uniform(1, 10)} for _ in range(count)
    ]
    if dimension == 2:
        problems = tuple(scene("stack", blocks=contacts // 2, **each).problem() for each in settings)
    else:
        problems = tuple(make_instance("cubes", boxes=contacts // 4, **each) for each in settings)
    spec = BASE[dimension]
    answers = solve_many(problems, spec, tol=TOL)
    bearing = np.concatenate([answers[k][:, 0] > 0 for k in range(count)])
    rested = [idle(problem, lambda given: solve(given, spec).impulse) for problem in problems[:SAMPLE]]
    return Case(contacts, dimension, problems, float(bearing.mean()), float(np.mean(rested)))


def rates(case: Case, workers: int, quiet: bool, looped: Sequence[str] = ()) -> Iterator[Rate]:
    """All ways of solving the case, or those of these solvers, called in turn in each round; threads only on a quiet
    machine."""
    whole, sample = Batch(case.problems), Batch(case.problems[:SAMPLE])
    ways: dict[str, Way] = {}
    base = BASE[case.dimension]
    for spec in (base, *ALONE):
        if available()[spec].missing is None and available()[spec].refuses(case.problems[0]) is None:
            ways[f"{spec}, single calls"] = Way(sample, partial(_one_by_one, sample, spec))
    for spec in looped or LOOPED[case.dimension]:
        ways[f"{spec}, packed"] = Way(whole, partial(_many, whole, spec))
        ways[f"{spec}, with packing"] = Way(whole, partial(_many, case.problems, spec))
    if case.dimension == 2 and available()["quantecon"].missing is None:
        ways["quantecon, compiled loop"] = quantecon(whole)
        ways["quantecon, our form and residuals"] = quantecon_from_bodies(whole)
    verified = {name: _verified(way) for name, way in ways.items()}  # also compiles and loads
    least = dict.fromkeys(ways, np.inf)
    for _ in range(ROUNDS):
        for name, way in ways.items():
            least[name] = min(least[name], _seconds(way.run, process_time) / len(way.batch))
    single = least[f"{base}, single calls"]
    for name in ways:
        spec, _, how = name.partition(", ")
        shares, gained = _details(whole, spec, single, least[name], workers, quiet) if how == "packed" else (None, None)
        yield Rate(name, single / least[name], verified[name], shares, gained, 1 / least[name])


Percentiles = tuple[float, float, float]


def _details(
    batch: Batch, spec: str, single: float, packed: float, workers: int, quiet: bool
) -> tuple[Percentiles, float | None]:
    """Percentiles of a problem's time over that of a single call, and what several threads gain. packed: s a problem."""
    times, repeats = [], max(AGAIN, math.ceil(SHORT / packed))
    for problem in batch.problems[:SAMPLE]:
        again = Batch([problem] * repeats)
        times.append(min(_seconds(partial(_many, again, spec), process_time) for _ in range(2)) / repeats / single)
    p50, p95, worst = (float(np.percentile(times, share)) for share in (50, 95, 100))
    if workers == 1 or not quiet:
        return (p50, p95, worst), 1.0 if workers == 1 else None
    long = Batch(batch.problems * math.ceil(LONG / (packed * len(batch))))
    runs = {number: partial(_many, long, spec, number) for number in (1, workers)}
    walls = [{number: _seconds(run, perf_counter) for number, run in runs.items()} for _ in range(ROUNDS)]
    return (p50, p95, worst), min(each[1] for each in walls) / min(each[workers] for each in walls)


def _seconds(run: Callable[[], Any], clock: Callable[[], float]) -> float:
    begun = clock()
    run()
    return clock() - begun


def _one_by_one(problems: Iterable[FrictionProblem], spec: str) -> Array:
    return np.concatenate([solve(problem.fresh(), spec, tol=TOL).impulse.ravel() for problem in problems])


def _many(problems: Any, spec: str, workers: int = 1) -> Array:
    return solve_many(problems, spec, tol=TOL, workers=workers).impulse


def _verified(way: Way) -> float:
    """The share of problems whose residual is within TOL."""
    ((_, packed),) = way.batch.groups
    impulse = way.impulses(way.run()).reshape(-1, packed.dimension)
    return float(np.mean(residuals(packed, impulse)[:, 0] <= TOL))


def quantecon(batch: Batch) -> Way:
    """A compiled loop over QuantEcon's kernel, on dense matrices that are made here."""
    lemke, options = kernel_of("tuned")  # by default it cycles among ties where matrices differ in their last bits
    forms = [dense_lcp(problem) for problem in batch]
    size = np.array([len(form.q) for form in forms])
    first, square = np.concatenate([[0], size.cumsum()]), np.concatenate([[0], (size**2).cumsum()])
    M, q = np.concatenate([form.M.ravel() for form in forms]), np.concatenate([form.q for form in forms])

    @njit(nogil=True)
    def loop(first, square, M, q):  # type: ignore[no-untyped-def]
        z = np.empty(len(q))
        for k in range(len(first) - 1):
            n = first[k + 1] - first[k]
            found = lemke(M[square[k] : square[k + 1]].reshape(n, n), q[first[k] : first[k + 1]], None, 100_000, options)
            z[first[k] : first[k + 1]] = found.z
        return z

    def impulses(z: Array) -> Array:
        parts = [form.answer(z[first[k] : first[k + 1]], Status.SOLVED).impulse.ravel() for k, form in enumerate(forms)]
        return np.concatenate(parts)

    return Way(batch, partial(loop, first, square, M, q), impulses)


def quantecon_from_bodies(batch: Batch) -> Way:
    """The same kernel in the place of ours, between our form of the bodies and the residuals of the impulses."""
    lemke, options = kernel_of("tuned")
    ((_, packed),), basis = batch.groups, tangent_basis(2)
    most = 4 * int(np.diff(packed.contacts).max())
    room = np.empty(most**2), np.empty(most * (2 * most + 2)), np.empty(most, np.int_), np.empty(most)

    @njit(nogil=True)
    def loop(packed, basis, lcp, M, tableau, places, z, r):  # type: ignore[no-untyped-def]
        for k in range(len(packed.first) - 1):
            _, stretch, columns, q, _ = scaled_lcp_of(packed, k, basis, lcp)
            n = len(q)
            dense, y = M[: n * n].reshape(n, n), z[:n]
            dense[:] = 0.0
            for j in range(n):
                for e in range(columns.start[j], columns.start[j + 1]):
                    dense[columns.rows[e], j] = columns.column[e]
            lemke(dense, q, None, 100_000, options, tableau[: n * (2 * n + 2)].reshape(n, 2 * n + 2), places[:n], y)
            write_stretched(basis, y, stretch, impulses_of(packed, k, r))

    def run() -> Array:
        r = np.empty((int(packed.contacts[-1]), 2))
        loop(packed, basis, lcp_space(packed, basis), *room, r)
        residuals(packed, r)
        return r

    return Way(batch, run)


def table(case: Case, found: list[Rate]) -> str:
    """The rates of a case in Markdown."""
    lines = [
        f"### {case.contacts} contacts in {'the plane' if case.dimension == 2 else 'space'}",
        f"{len(case.problems)} problems; {100 * case.active:.0f} % of the contacts bear, and in {100 * case.idle:.0f} % of the "
        "problems friction is idle.",
        "| | rate | p50 | p95 | worst | threads |\n|---|--:|--:|--:|--:|--:|",
    ]
    rows = []
    for rate in found:
        why = refusal(case, rate)
        shares = [f"{share:.2f}" for share in rate.percentiles] if rate.percentiles and not why else ["", "", ""]
        gained = f"{rate.threads:.2f}" if rate.threads and not why else "busy" if rate.percentiles and not why else ""
        rows.append(f"| {rate.way} | {why or f'{rate.ratio:.2g}'} | {' | '.join(shares)} | {gained} |")
    return "\n\n".join(lines) + "\n" + "\n".join(rows) + "\n"


def lines(case: Case, found: list[Rate]) -> Iterator[str]:
    """The lines of a table of COLUMNS; where a rate says nothing stands why, and no times."""
    for rate in found:
        why = refusal(case, rate)
        numbers = (why, "") if why else (rate.per_second, rate.ratio)
        times = ("",) * 4 if why else (*(rate.percentiles or ("",) * 3), rate.threads or "")
        parts = (case.dimension, case.contacts, case.active, case.idle, rate.way, *numbers, rate.verified, *times)
        yield "\t".join(f"{part:.4g}" if isinstance(part, float) else str(part) for part in parts)


def tables(
    dimension: int, contacts: Sequence[int], count: int, solvers: Sequence[str], workers: int
) -> Iterator[tuple[str, list[str]]]:
    """For each number of contacts the table in Markdown and the lines of COLUMNS, of so many problems.

    Errors: InputError naming contacts, count, workers or solver.
    """
    step = 2 if dimension == 2 else 4
    for each in contacts:
        require(each >= step and each % step == 0, "contacts", f"boxes have {step} each: must be a multiple of it, got {each}")
    require(count >= 1, "count", f"must be at least 1, got {count}")
    require(workers >= 1, "workers", f"must be at least 1, got {workers}")
    for spec in solvers:
        info, _ = find(spec)
        require(info.missing is None, "solver", str(info.missing))
        require(dimension in info.dimension, "solver", f"{spec} takes no problems of dimension {dimension}")
    for each in contacts:
        case = make_case(dimension, each, count)
        found = list(rates(case, workers, os.getloadavg()[0] < QUIET, solvers))
        yield table(case, found), list(lines(case, found))


def page() -> str:
    """docs/performance.md."""
    workers, quiet = len(os.sched_getaffinity(0)), os.getloadavg()[0] < QUIET
    head = HEAD.format(rounds=ROUNDS, sample=SAMPLE, again=AGAIN, workers=workers)
    cases = [make_case(dimension, *each) for dimension, sizes in SIZES.items() for each in sizes.items()]
    parts = [table(case, list(rates(case, workers, quiet))) for case in cases]
    return "\n".join([head, *parts, large.section(), seeds.section(), members.section()])


if __name__ == "__main__":
    sys.stdout.write(page())
