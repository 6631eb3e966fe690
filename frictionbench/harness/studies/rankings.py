"""What do published rankings look like under one verifier? Methods of published comparisons, measured again."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from frictionbench.harness.plans import families
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.plans.recorded import located
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.frictionless import frictionless_answer, idle
from frictionbench.problems.check import Array
from frictionbench.problems.instances import make_instance
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.problems.scenes import scene
from frictionbench.results.store import Row
from frictionbench.solvers import Answer, Status, available, find, solve

TOL = 1e-8
SMALL = tuple(
    source
    for source in families.sources(families.SPACE_ONE, families.SPACE_SMALL, families.SPACE_MEDIUM)
    if source.scene != "packed_spheres"
)
SIMILAR = {"nsgs": "sweeps", "apgd_coulomb": "products", "interior_point": "factorisations"}  # Coulomb's law
RELAXED = {"apgd": "products", "relaxation_ip": "factorisations"}  # the same methods on the convex relaxation
PROXIMAL = "proximal_newton"
PLAIN: dict[str, Callable[[Array, Array], Array]] = {  # Newton's method by LU factors, and by steps of least norm
    "plain_newton": lambda A, b: np.asarray(np.linalg.solve(A, b), dtype=float),
    "least_newton": lambda A, b: np.asarray(np.linalg.lstsq(A, b, rcond=1e-12)[0], dtype=float),
}
TYPES = {  # the kinds of method in Acary, Brémond and Huber 2018, ours and, where Siconos is installed, their own
    "nsgs": ("nsgs", "siconos[method=friction_3d_nsgs]"),
    "proximal": (PROXIMAL, "siconos[method=friction_3d_prox]"),
    "newton": ("siconos[method=friction_3d_nsn_ac]",),
}
LARGER = families.halves(families.SPACE_LARGE)
OTHERS = ("interior_point", "staggered", "nncg", "admm_coulomb", "apgd_coulomb", "relaxation_ip", "apgd")
ITERATIONS = ("pivots", "iterations", "sweeps", "rounds", "relaxations", "newton", "anchors")  # as methods name them
WITHOUT_FRICTION = {"resting": 0.0, "lifted": 0.0, "pushed": 0.5}  # a stack of five blocks: the push on its lowest, N s/kg


def ranks(sources: Iterable[Source] = SMALL, compliances: Iterable[float] = (0.0, 1e-3)) -> Iterator[Row]:
    """Each problem with its own Delassus matrix, and with contacts made compliant, which gives it full rank."""
    for number, source in enumerate(sources):
        own = make_instance(source.scene, **source.parameters)
        for compliance in compliances:
            W = own.W + compliance * np.diag(np.repeat(own.scale, 3))
            problem = FrictionProblem.from_delassus(W, own.q, own.friction, 3, own.friction_bias)
            facts = {"number": number, "scene": source.scene, "contacts": own.contacts, "compliance": compliance}
            facts |= {"rank": int(np.linalg.matrix_rank(W, hermitian=True)), "unknowns": len(W)}
            answers = {name: solve(problem, name, tol=TOL) for name in (PROXIMAL, *SIMILAR, *RELAXED)}
            answers |= {name: plain_newton(problem, step_of) for name, step_of in PLAIN.items()}
            for name, answer in answers.items():
                relaxed = name in RELAXED
                found = (relaxation_residual if relaxed else residual)(problem, answer.impulse)
                count = answer.work[(SIMILAR | RELAXED).get(name, "factorisations")]
                verdict = {"solved": bool(found <= TOL), "residual": found, "work": count}
                yield facts | {"method": name, "relaxed": relaxed} | verdict


def plain_newton(
    problem: FrictionProblem, step_of: Callable[[Array, Array], Array], tol: float = TOL, limit: int = 200, halvings: int = 8
) -> Answer:
    """Newton's method on Alart and Curnier's equations with the dense W, a line search and nothing besides.

    With x = r - u / s, u = W r + q, it seeks F = r - P(x) = 0, where P(x) is the positive part of x_n, and x_t projected on the
    disc of radius mu (x_n)_+. step_of(A, b) solves A x = b.
    """
    W, q, mu, nc = problem.W, problem.q, problem.friction, problem.contacts
    weight = np.repeat(problem.scale, 3)

    def equations(r: Array) -> tuple[Array, Array]:
        """s F (3 nc,) and its derivative."""
        x = (r - (W @ r + q) / weight).reshape(nc, 3)
        normal, size = np.maximum(x[:, 0], 0.0), np.linalg.norm(x[:, 1:], axis=1)
        P, D = np.zeros((nc, 3)), np.zeros((nc, 3, 3))
        P[:, 0], D[:, 0, 0] = normal, x[:, 0] > 0
        for i in range(nc):
            radius = mu[i] * normal[i]
            if size[i] <= radius:
                P[i, 1:], D[i, 1:, 1:] = x[i, 1:], np.eye(2)
            else:
                along = x[i, 1:] / size[i]
                P[i, 1:], D[i, 1:, 0] = radius * along, mu[i] * D[i, 0, 0] * along
                D[i, 1:, 1:] = radius / size[i] * (np.eye(2) - np.outer(along, along))
        slope = np.eye(3 * nc) - W / weight[:, None]
        for i in range(nc):
            slope[3 * i : 3 * i + 3] = D[i] @ slope[3 * i : 3 * i + 3]
        return weight * (r - P.ravel()), weight[:, None] * (np.eye(3 * nc) - slope)

    r, work = np.zeros(3 * nc), 0
    value, slope = equations(r)
    while residual(problem, r.reshape(nc, 3)) > tol and work < limit:
        try:
            step = step_of(slope, -value)
        except np.linalg.LinAlgError:
            break
        work += 1
        for halving in range(halvings + 1):
            ahead, ahead_slope = equations(r + step / 2**halving)
            if np.linalg.norm(ahead) < np.linalg.norm(value):
                break
        if not np.isfinite(ahead).all():
            break
        r, value, slope = r + step / 2**halving, ahead, ahead_slope
    solved = residual(problem, r.reshape(nc, 3)) <= tol
    return Answer(r.reshape(nc, 3), Status.SOLVED if solved else Status.STALLED, {"factorisations": work})


def evidence(blocks: int = 5) -> Iterator[Row]:
    """Every method of ours for Coulomb's law on a stack that rests, is lifted off or pushed, from zero and a given answer."""
    exact = [
        (spec, info)
        for spec, info in sorted(available().items())
        if info.ours and not info.needs and info.model != "relaxation"
    ]
    for kind, push in WITHOUT_FRICTION.items():
        problem = scene("stack", blocks=blocks, push=push).problem()
        if kind == "lifted":
            problem = problem.replace(free_velocity=-problem.free_velocity)
        given = frictionless_answer(problem, _exact)
        facts = {"kind": kind, "idle": idle(problem, _exact), "trivial": bool((problem.q.reshape(-1, 2)[:, 0] >= 0).all())}
        for spec, info in exact:
            solver = find(spec)[0]
            if 2 not in solver.dimension:
                continue
            for start in ("zero", "given") if info.warm_start else ("zero",):
                answer = solve(problem, spec, tol=TOL, start=given if start == "given" else None)
                work = sum(value for name, value in answer.work.items() if name.split()[-1] in ITERATIONS)
                yield facts | {
                    "solver": spec,
                    "start": start,
                    "iterations": work,
                    "residual": residual(problem, answer.impulse),
                }


def _exact(problem: FrictionProblem) -> Array:
    return solve(problem, "hybrid", tol=1e-12).impulse


def plan() -> Plan:
    """Problems in space with times, by the kinds of method of the published comparisons."""
    return Plan(
        suite="study rankings",
        sources=tuple(replace(source, repeats=3) for source in (*SMALL, *LARGER)),
        solvers=(*(name for names in TYPES.values() for name in names), *OTHERS),
        tolerances=(1e-4, 1e-8),
        time_limit=1.0,
    )


def recorded(locations: Sequence[str]) -> Plan:
    """The same for recorded problems at these locations. Errors: InputError naming `data`."""
    sources = tuple(replace(source, repeats=3) for location in locations for source in located(location))
    return replace(plan(), suite="study rankings, recorded", sources=sources)


STUDY = Study(
    name="rankings",
    question="What do published rankings look like under one verifier?",
    method="""The kinds of method that Acary, Brémond and Huber 2018 compare, ours and, where Siconos is installed, their own,
    and five others are run on problems in space at 1e-4 and 1e-8, a second a solve; every answer is verified by one residual;
    recorded problems are treated alike where their folder is given. A finding is confirmed or contradicted where all sets of
    problems say so, in part where they differ, half of it holds or chance may explain it, and not tested where these problems
    cannot tell. Small ones are also solved with their own Delassus matrix and with contacts made compliant by a thousandth of
    their scale, which gives the matrix full rank and leaves friction as it is, by methods for Coulomb's law and the same ones
    on its convex relaxation, and by a plain Newton's method, with LU factors and with steps of least norm. A stack at rest,
    lifted off and pushed goes to every method, from zero and from one given answer.""",
    tables=(
        Table(
            ranks,
            {
                "number": "of the problem",
                "scene": "instance",
                "contacts": "number of contacts",
                "compliance": "added to the diagonal of W, over the contact's mean diagonal",
                "rank": "of W",
                "unknowns": "rows of W",
                "method": "solver; plain_newton or least_newton, Newton's method by LU factors or by steps of least norm",
                "relaxed": "whether it solves the convex relaxation",
                "solved": "whether its own model is solved to 1e-8",
                "residual": "of its own model",
                "work": "sweeps of nsgs, products with W of apgd and apgd_coulomb, else factorisations",
            },
        ),
        Table(
            evidence,
            {
                "kind": "of problem: a stack that rests, is lifted off, or is pushed",
                "idle": "whether friction is not needed",
                "trivial": "whether zero impulses are the answer",
                "solver": "solver",
                "start": "zero, or a given answer without friction",
                "iterations": "all that the method counts as such",
                "residual": "of Coulomb's law",
            },
        ),
    ),
    plan=plan,
    recorded=recorded,
)
