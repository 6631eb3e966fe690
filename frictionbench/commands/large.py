"""The second part of docs/performance.md: large problems, one by one.

Each method is timed on the same problem, form, setup and solve, by the processor's time, ROUNDS times in turn; the least time
counts, over that of the interior point. How that itself grows from size to size is told beside it. A time is shown only where
the residual is within TOL; methods whose dense matrices would exceed STORAGE, and those that took LONG on a smaller problem of
the family, are not run.
"""

from collections.abc import Iterator
from time import process_time

from frictionbench.harness.plans.choose import problem_of
from frictionbench.problems import FrictionProblem
from frictionbench.problems.residual import residual
from frictionbench.solvers import find, solve
from frictionbench.solvers.interface import dense_storage

FAMILIES = {
    "stack of boxes": ("stack", "blocks", (100, 300, 1000, 3000)),
    "pyramid of boxes": ("pyramid", "rows", (8, 14, 20, 31)),
    "chain of hinged links in the plane": ("chain", "links", (100, 700, 2000)),
    "chain of rods with ball joints in space": ("rod_chain", "links", (100, 700, 2000)),
}
METHODS = ("interior_point", "hybrid", "path_search", "lemke")
TOL, ROUNDS, LONG, STORAGE = 1e-8, 3, 10.0, 2**31
HEAD = f"""## Large problems

Times of single calls over that of `interior_point` on the same problem in the same run, form, setup and solve together, by the
processor's time, the least of {ROUNDS} in turn. *growth* is the time of `interior_point` over that at the family's first size.
A problem has as many unknowns of its friction LCP as stand in *unknowns*; joints make W dense, so that methods of the LCP are
not run with them. A dash: not run, where the method took more than {LONG:g} s at a smaller size or where its dense matrices
need more than {STORAGE / 2**30:g} GiB. A residual stands where it is above {TOL:g}.
"""


def section() -> str:
    """The section in Markdown."""
    return "\n".join([HEAD, *(_table(title, *family) for title, family in FAMILIES.items())])


def _table(title: str, name: str, parameter: str, sizes: tuple[int, ...]) -> str:
    lines = [f"### {title.capitalize()}\n", f"| {parameter} | contacts | unknowns | growth | {' | '.join(METHODS[1:])} |"]
    lines.append("|--:" * (len(METHODS) + 3) + "|")
    late: set[str] = set()
    first = None
    dict(_times(problem_of(name, {parameter: 3}), set()))  # compiles and loads
    for size in sizes:
        problem = problem_of(name, {parameter: size})
        found = dict(_times(problem, late))
        base = found["interior_point"][0]
        first = first or base
        shown = [_shown(found.get(method), base) for method in METHODS[1:]]
        unknowns = problem.contacts * 4 if problem.dimension == 2 else problem.contacts * 3
        lines.append(f"| {size} | {problem.contacts} | {unknowns} | {base / first:.3g} | {' | '.join(shown)} |")
    return "\n".join(lines) + "\n"


def _times(problem: FrictionProblem, late: set[str]) -> Iterator[tuple[str, tuple[float, float]]]:
    """The least time and the residual of each method that is run; `late` gathers those that took long."""
    joined = len(problem.joint_bias) > 0
    for method in METHODS:
        info, instance = find(method)
        if method in late or dense_storage(instance, problem) > STORAGE or (joined and info.model == "lcp"):
            continue
        least, worst = float("inf"), 0.0
        for _ in range(ROUNDS):
            given = problem.fresh()
            begun = process_time()
            answer = solve(given, method, tol=TOL)
            least = min(least, process_time() - begun)
            worst = max(worst, residual(problem, answer.impulse))
            if least > LONG:
                late.update({method} - {METHODS[0]})
                break
        yield method, (least, worst)


def _shown(found: tuple[float, float] | None, base: float) -> str:
    if found is None:
        return "–"  # a dash in a table
    time, worst = found
    return f"{time / base:.2g}" if worst <= TOL else f"{worst:.0e}"
