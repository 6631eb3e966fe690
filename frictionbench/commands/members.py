"""The fourth part of docs/performance.md: hybrid beside its members by size, and path_search beside PATH.

All times are of single calls, the processor's, the least of ROUNDS in turn; those of small problems are means over as many
copies as take SHORT seconds. PATH runs in a process of GAMS: its time is the one in its own log.
"""

from collections.abc import Callable
from functools import partial
from time import process_time

from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.instances import make_instance
from frictionbench.problems.residual import residual
from frictionbench.solvers import available, find, solve

TOL, ROUNDS, SHORT = 1e-8, 7, 0.01
PLANAR, SPATIAL = ("lemke", "interior_point"), ("nsgs", "interior_point")
STACKS = {2: (1, 2, 5, 10, 18, 25, 50, 150, 500), 3: (1, 2, 3, 10, 25, 100, 250)}  # boxes
PATHS = (("stack", "blocks", (10, 30, 60)), ("pyramid", "rows", (5, 8, 10)))  # of at most a thousand unknowns: GAMS' licence
HEAD = f"""## Portfolio and members

Times of `hybrid` over those of the faster of the two members that it begins with, form, setup and solve together, on boxes on
each other of which the topmost is pushed. Every answer is within {TOL:g}; a member that does not reach it is not counted.
"""
PATH_HEAD = """### path_search and PATH

Time of `path_search`, without the form of the LCP, over PATH's, the total time in its own log, on the same scaled LCP from
z = 0. PATH is called by GAMS with its demonstration licence, which ends at a thousand rows, at its default settings. A dash:
where GAMSPy is not installed, or PATH does not solve the problem.
"""


def section() -> str:
    """The section in Markdown."""
    return "\n".join([HEAD, _portfolio(2, "the plane"), _portfolio(3, "space"), PATH_HEAD, _path()])


def _portfolio(dimension: int, where: str) -> str:
    """The table of hybrid in the plane or in space."""
    lines = [f"### In {where}\n", "| boxes | contacts | hybrid | fastest member |", "|--:|--:|--:|:--|"]
    for boxes in STACKS[dimension]:
        problem = scene("stack", blocks=boxes, push=1.0).problem() if dimension == 2 else make_instance("cubes", boxes=boxes)
        seconds = _in_turn(problem, ("hybrid", *(PLANAR if dimension == 2 else SPATIAL)))
        hybrid, fastest = seconds.pop("hybrid"), min(seconds, key=lambda name: seconds[name])
        lines.append(f"| {boxes} | {problem.contacts} | {hybrid / seconds[fastest]:.2f} | {fastest} |")
    return "\n".join(lines) + "\n"


def _in_turn(problem: FrictionProblem, specs: tuple[str, ...]) -> dict[str, float]:
    """The least time of a call of each solver, s; infinity where it does not solve the problem."""
    calls = {spec: partial(solve, spec=spec, tol=TOL) for spec in specs}
    solved = [spec for spec in specs if residual(problem, calls[spec](problem).impulse) <= TOL]
    counts = {spec: max(1, int(SHORT / _mean(problem, calls[spec], 1))) for spec in solved}
    rounds = [{spec: _mean(problem, calls[spec], counts[spec]) for spec in solved} for _ in range(ROUNDS)]
    return {spec: min(each.get(spec, float("inf")) for each in rounds) for spec in specs}


def _mean(problem: FrictionProblem, call: Callable[[FrictionProblem], object], count: int) -> float:
    copies = [problem.fresh() for _ in range(count)]
    begun = process_time()
    for copy in copies:
        call(copy)
    return max((process_time() - begun) / count, 1e-9)


def _path() -> str:
    """The table of path_search beside PATH."""
    lines = ["| problem | unknowns | path_search |", "|:--|--:|--:|"]
    for name, parameter, sizes in PATHS:
        for size in sizes:
            problem = scene(name, **{parameter: size}).problem()
            theirs = _clock_of_path(problem)
            shown = f"{_own_time(problem) / theirs:.2g}" if theirs else "–"  # a dash in a table
            lines.append(f"| {name}, {parameter} = {size} | {4 * problem.contacts} | {shown} |")
    return "\n".join(lines) + "\n"


def _own_time(problem: FrictionProblem) -> float:
    """The least time of setup and solve of path_search, s."""
    _, method = find("path_search")
    form = method.form(problem)
    return min(_mean(problem, lambda _: method.solve(method.setup(form), TOL, None), 1) for _ in range(ROUNDS))


def _clock_of_path(problem: FrictionProblem) -> float | None:
    """The least time in PATH's log, s; None where it is not installed or does not solve the problem."""
    if available()["path"].missing:
        return None
    answers = [solve(problem.fresh(), "path", tol=TOL) for _ in range(ROUNDS)]
    if any(answer.clock is None or residual(problem, answer.impulse) > TOL for answer in answers):
        return None
    return min(answer.clock for answer in answers if answer.clock)
