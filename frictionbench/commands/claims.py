"""What an adapter claims beside what its library claims when it is called by hand (harness.direct), on the steps of scenes.

A near miss or a wrong claim of an adapter is the library's own where the call by hand claims as much on the same problem and is
as far off. The steps are those of a motion by reference answers; problems with joints, a friction bias or no contacts are left
out, since the calls by hand do not take them. Of both, the residual is that of the solver's own model.
"""

from collections.abc import Iterable

import numpy as np
from rich.markup import escape
from rich.table import Table

from frictionbench.commands.charged import TOL, chosen
from frictionbench.harness.cells.reference import Reference
from frictionbench.harness.direct import CALLS
from frictionbench.harness.direct.given import arrays
from frictionbench.harness.verify import verify
from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.schemes import SCHEMES, require_scheme
from frictionbench.problems.simulate import simulate
from frictionbench.problems.spec import parse
from frictionbench.results.conventions import DEFAULT_SCHEME
from frictionbench.solvers import Answer, Status, find


def claims_table(solvers: list[str], scenes: list[str], scheme: str = DEFAULT_SCHEME) -> Table:
    """A row for each library and scene, or for the solvers named: the claims of both, and those that are off, with the largest
    residual. Errors: InputError as of charged_table, and naming scene or scheme.
    """
    require_scheme(scheme)
    table = Table("solver", "scene", "problems", "adapter claims", "off", "by hand claims", "off", "off in both")
    specs = chosen(solvers)
    for named in scenes:
        problems = list(steps(named, scheme))
        for spec in specs:
            missing = find(spec)[0].missing
            table.add_row(escape(spec), escape(named), *((missing,) if missing else _row(spec, problems)))
    return table


def steps(named: str, scheme: str) -> Iterable[FrictionProblem]:
    """The problems in the plane that a call by hand takes, of a scene's motion."""
    name, settings = parse("scene", named)
    stage, reference, met = scene(name, **settings), Reference(), []

    def record(problem: FrictionProblem) -> np.ndarray:
        met.append(problem)
        return reference(problem)

    for _ in simulate(stage, record, SCHEMES[scheme], stage.steps):
        taken = (p for p in met if p.contacts and not (p.friction_bias.any() or len(p.joint_bias)))
        yield from taken
        met.clear()


def _row(spec: str, problems: list[FrictionProblem]) -> tuple[str, ...]:
    """The numbers of problems and claims, and of claims that are off with their largest residual."""
    ours, theirs = [], []
    for problem in problems:
        _, solver = find(spec)
        ours.append(_off(spec, problem, solver.solve(solver.prepare(problem.fresh()), TOL, None)))
        called = CALLS[spec](arrays(problem), TOL)
        status = Status.SOLVED if called.claimed else Status.FAILED
        theirs.append(_off(spec, problem, Answer(called.impulse, status)))
    both = sum(one > TOL and other > TOL for one, other in zip(ours, theirs, strict=True))
    return str(len(problems)), *_told(ours), *_told(theirs), str(both)


def _off(spec: str, problem: FrictionProblem, answer: Answer) -> float:
    """The residual of a claimed answer in its own model; NaN where it claims nothing."""
    found = verify(problem, answer, find(spec)[0], TOL)
    return min(found.residual, found.model_residual) if answer.status is Status.SOLVED else np.nan


def _told(residuals: list[float]) -> tuple[str, str]:
    claimed = [residual for residual in residuals if not np.isnan(residual)]
    off = [residual for residual in claimed if residual > TOL]
    return str(len(claimed)), f"{len(off)}, up to {max(off):.1e}" if off else "0"
