"""The section of docs/performance.md on single calls on large problems.

The processor time of form, setup and solve of each method is measured ROUNDS times on the same problem. The table shows the
least time relative to that of interior_point, and the growth of the latter with the size. A time is shown only if the residual
is within TOL. Methods whose two dense matrices would exceed STORAGE bytes, or that took LONG on a smaller problem of the
family, are not run.
"""

from collections.abc import Iterator
from time import process_time

import frictionbench as fb
from frictionbench.problems import FrictionProblem
from frictionbench.solvers import find

FAMILIES = {
    "stack of boxes": ("stack", "blocks", (100, 300, 1000, 3000)),
    "pyramid of boxes": ("pyramid", "rows", (8, 14, 20, 31)),
    "chain of hinged links in the plane": ("chain", "links", (100, 700, 2000)),
    "chain of rods with ball joints in space": ("rod_chain", "links", (100, 700, 2000)),
}
METHODS = ("interior_point", "hybrid", "path_search", "lemke")
TOL, ROUNDS, LONG, STORAGE = 1e-8, 3, 10.0, 2**31
HEAD = f"""## Large problems

Each entry is the time of a method over that of `interior_point` on the same problem in the same run: form, setup and solve,
in processor time, the least of {ROUNDS} rounds. *growth* is the time of `interior_point` over that at the family's first size.
*unknowns* counts those of the friction LCP. Joints make W dense, so that methods of the LCP are not run with them. A dash
means not run: the method took more than {LONG:g} s at a smaller size, or its dense matrices need more than
{STORAGE / 2**30:g} GiB. If the residual is above {TOL:g}, it is shown instead of the time.
"""


def section() -> str:
    """Return the section in Markdown."""
    return "\n".join([HEAD, *(_table(title, *family) for title, family in FAMILIES.items())])


def _table(title: str, name: str, parameter: str, sizes: tuple[int, ...]) -> str:
    lines = [f"### {title.capitalize()}\n", f"| {parameter} | contacts | unknowns | growth | {' | '.join(METHODS[1:])} |"]
    lines.append("|--:" * (len(METHODS) + 3) + "|")
    late: set[str] = set()
    first = None
    dict(_times(_problem(name, parameter, 3), set()))  # compiles and loads
    for size in sizes:
        problem = _problem(name, parameter, size)
        times = dict(_times(problem, late))
        base = times["interior_point"][0]
        first = first or base
        shown = [_shown(times.get(method), base) for method in METHODS[1:]]
        lines.append(f"| {size} | {problem.contacts} | {_unknowns(problem)} | {base / first:.3g} | {' | '.join(shown)} |")
    return "\n".join(lines) + "\n"


def _problem(name: str, parameter: str, size: int) -> FrictionProblem:
    parameters = {parameter: size}
    return fb.scene(name, **parameters).problem() if name in fb.scenes() else fb.instance(name, **parameters)


def _unknowns(problem: FrictionProblem) -> int:
    """Return the number of unknowns: of the LCP in the plane, of the impulses in space."""
    return problem.contacts * (4 if problem.dimension == 2 else 3)


def _times(problem: FrictionProblem, late: set[str]) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield the least time and the largest residual of each method that is run; methods that took long are added to `late`."""
    joined = len(problem.joint_bias) > 0
    for method in METHODS:
        lcp = find(method)[0].model == "lcp"
        if method in late or (lcp and (joined or 16 * _unknowns(problem) ** 2 > STORAGE)):
            continue
        least, worst = float("inf"), 0.0
        for _ in range(ROUNDS):
            fresh = problem.fresh()
            begun = process_time()
            answer = fb.solve(fresh, method, tol=TOL)
            least = min(least, process_time() - begun)
            worst = max(worst, fb.residual(problem, answer.impulse))
            if least > LONG:
                late.update({method} - {METHODS[0]})
                break
        yield method, (least, worst)


def _shown(timed: tuple[float, float] | None, base: float) -> str:
    if timed is None:
        return "–"  # a dash in a table
    time, worst = timed
    return f"{time / base:.2g}" if worst <= TOL else f"{worst:.0e}"
