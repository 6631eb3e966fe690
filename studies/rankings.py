"""What do published rankings look like under one verifier? Methods of published comparisons, measured again."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench import Verdict
from frictionbench.harness import Plan, Source, families, located
from frictionbench.problems import FrictionProblem, frictionless_answer, idle, relaxation_residual
from frictionbench.reports import Look, Panel, looks
from frictionbench.solvers import Answer, Status, available, find, solve
from studies.findings import AGREES, DIFFERS, LOOSE, OPEN, PAIRS, PARTLY, TIGHT, findings, needing, without_rank
from studies.motions import by
from studies.study import RECORDED, Array, Row, Study, Summary, Tables, curve, finish, require, share, wilson

START = {"resting": "given", "lifted": "zero"}  # the start that is told, of problems that need no friction
NONE = 0.5  # where no iteration is drawn, on a logarithmic axis
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
    """Each problem with its own Delassus matrix, and with contacts made compliant, which gives it full rank.

    scene: instance; compliance: added to the diagonal of W, over the contact's mean diagonal; rank: of W; unknowns: rows of
    W; method: solver; plain_newton or least_newton, Newton's method by LU factors or by steps of least norm; relaxed:
    whether it solves the convex relaxation; solved: whether its own model is solved to 1e-8; residual: of its own model;
    work: sweeps of nsgs, products with W of apgd and apgd_coulomb, else factorisations.
    """
    for number, source in enumerate(sources):
        own = fb.instance(source.scene, **source.parameters)
        for compliance in compliances:
            W = own.W + compliance * np.diag(np.repeat(own.scale, 3))
            problem = FrictionProblem.from_delassus(W, own.q, own.friction, 3, own.friction_bias)
            facts = {"number": number, "scene": source.scene, "contacts": own.contacts, "compliance": compliance}
            facts |= {"rank": int(np.linalg.matrix_rank(W, hermitian=True)), "unknowns": len(W)}
            answers = {name: solve(problem, name, tol=TOL) for name in (PROXIMAL, *SIMILAR, *RELAXED)}
            answers |= {name: plain_newton(problem, step_of) for name, step_of in PLAIN.items()}
            for name, answer in answers.items():
                relaxed = name in RELAXED
                found = (relaxation_residual if relaxed else fb.residual)(problem, answer.impulse)
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
    while fb.residual(problem, r.reshape(nc, 3)) > tol and work < limit:
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
    solved = fb.residual(problem, r.reshape(nc, 3)) <= tol
    return Answer(r.reshape(nc, 3), Status.SOLVED if solved else Status.STALLED, {"factorisations": work})


def evidence(blocks: int = 5) -> Iterator[Row]:
    """Every method of ours for Coulomb's law on a stack that rests, is lifted off or pushed, from zero and a given answer.

    kind: of problem: a stack that rests, is lifted off, or is pushed; idle: whether friction is not needed; trivial:
    whether zero impulses are the answer.
    """
    exact = [
        (spec, info)
        for spec, info in sorted(available().items())
        if info.ours and not info.needs and info.model != "relaxation"
    ]
    reference = by("hybrid", 1e-12)
    for kind, push in WITHOUT_FRICTION.items():
        problem = fb.scene("stack", blocks=blocks, push=push).problem()
        if kind == "lifted":
            problem = problem.replace(free_velocity=-problem.free_velocity)
        given = frictionless_answer(problem, reference)
        facts = {"kind": kind, "idle": idle(problem, reference), "trivial": bool((problem.q.reshape(-1, 2)[:, 0] >= 0).all())}
        for spec, info in exact:
            solver = find(spec)[0]
            if 2 not in solver.dimension:
                continue
            for start in ("zero", "given") if info.warm_start else ("zero",):
                answer = solve(problem, spec, tol=TOL, start=given if start == "given" else None)
                work = sum(value for name, value in answer.work.items() if name.split()[-1] in ITERATIONS)
                yield facts | {
                    "solver": spec,
                    "start": start,  # zero, or a given answer without friction
                    "iterations": work,  # all that the method counts as such
                    "residual": fb.residual(problem, answer.impulse),  # of Coulomb's law
                }


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


def summary(found: Tables) -> Summary:
    ranks, evidence = found["ranks"], found["evidence"]
    solves = [found[name] for name in ("solves", RECORDED) if name in found]
    sets = [needing(rows) for rows in solves]
    short, cured = without_rank(ranks[ranks["method"] == "plain_newton"])
    least, _ = without_rank(ranks[ranks["method"] == "least_newton"])
    require((cured["rank"] == cured["unknowns"]).all(), "compliance gives full rank")
    require(least["solved"].sum() > short["solved"].sum(), "singular factors are one cause of failures without rank")
    rows = findings(sets, ranks)
    verdicts = [row[-1] for row in rows]
    missed = [own[~own["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])] for own in sets]
    sizes = [one.groupby("problem")["contacts"].first() for one in sets]
    told = {kind: evidence[(evidence["kind"] == kind) & (evidence["start"] == start)] for kind, start in START.items()}
    alike = {kind: _alike(own) for kind, own in told.items()}
    working = evidence[~evidence["idle"]]
    require(told["resting"]["idle"].all() and told["lifted"]["trivial"].all(), "what rests or is lifted off is idle")
    require((working["iterations"] > 0).all(), "no method is without iterations where friction is at work")
    left = [int(one.groupby("problem")[["idle", "trivial"]].first().any(axis=1).sum()) for one in solves]
    numbers = {
        "rows": rows,
        "confirmed": verdicts.count(AGREES),
        "partly": verdicts.count(PARTLY),
        "contradicted": verdicts.count(DIFFERS),
        "untested": verdicts.count(OPEN),
        "alike": alike["lifted"][2],
        "methods": alike["lifted"][1],
        "generated": sets[0]["problem"].nunique(),
        "has_recorded": len(sets) > 1,
        "recorded": sets[-1]["problem"].nunique(),
        "left": left[-1],
        "missed": sum(map(len, missed)),
        "timeouts": sum(int(one["verdict"].eq(Verdict.TIMEOUT).sum()) for one in missed),
        "short": share(short["solved"].sum(), len(short)),
        "cured": share(cured["solved"].sum(), len(cured)),
        "least": share(least["solved"].sum(), len(least)),
        "resting": _said(alike["resting"]),
        "lifted": _said(alike["lifted"]),
        "working": working["solver"].nunique(),
        "largest_generated": sizes[0].max(),
        "largest_recorded": sizes[-1].max(),
        "few": int((sizes[-1] < 10).sum()),
    }
    figures = {
        "profiles": tuple(
            Panel(f"to {tol:g}", partial(_profile, rows=sets[0], tol=tol, looks=_looks(sets[0]))) for tol in (LOOSE, TIGHT)
        ),
        "causes": (
            Panel("with and without rank", partial(_solved, ranks=ranks)),
            Panel("a stack at rest", partial(_evidence, rows=evidence[evidence["kind"] == "resting"])),
        ),
    }
    return Summary(numbers, figures, _looks(sets[0]))


def _alike(rows: pd.DataFrame) -> tuple[int, int, int, float]:
    """How many solvers have no iteration, of how many; how many of these have the commonest residual, and which it is."""
    none = rows.loc[rows["iterations"] == 0, "residual"]
    common = none.value_counts()
    return len(none), len(rows), int(common.iloc[0]), float(common.index[0])


def _said(alike: tuple[int, int, int, float]) -> str:
    none, of, same, value = alike
    return f"{none} of {of} methods report no iteration, and {same} of them the residual {value:.0e}, equal to the last digit"


def _looks(rows: pd.DataFrame) -> dict[str, Look]:
    """Of the methods for Coulomb's law."""
    return looks(name for name in rows["name"].unique() if name not in PAIRS.values())


def _profile(ax: Axes, rows: pd.DataFrame, tol: float, looks: dict[str, Look]) -> None:
    own = rows[(rows["tol"] == tol) & rows["name"].isin(list(looks))]
    best = own[own["solved"]].groupby("problem")["time"].min()
    for name, mine in own.groupby("name"):
        solved = mine[mine["solved"]]
        ratio = np.sort(solved["time"].to_numpy(float) / best[solved["problem"]].to_numpy(float))
        x, done = np.concatenate([[1], ratio, [1e4]]), np.minimum(np.arange(len(ratio) + 2), len(ratio))
        ax.step(x, done / own["problem"].nunique(), where="post", **looks[str(name)].line | {"marker": ""})
    finish(ax, "times the fastest", "share of problems", "x", xlim=(1, 1e3), ylim=(0, 1.03))


def _solved(ax: Axes, ranks: pd.DataFrame) -> None:
    for k, (rows, label) in enumerate(zip(without_rank(ranks), ("W lacks rank", "compliant contacts"), strict=True)):
        table = rows.groupby("method")["solved"].agg(["sum", "count"])
        at = np.arange(len(table)) + 0.2 * k - 0.1
        ends = np.array([wilson(int(done), int(of)) for done, of in table.to_numpy()])
        curve(ax, k, table["sum"] / table["count"], at, label, ls="")
        ax.hlines(at, *ends.T, color=ax.lines[-1].get_color(), lw=0.8)
    ax.set_yticks(range(len(table)), list(table.index))
    finish(ax, "share solved", "")


def _evidence(ax: Axes, rows: pd.DataFrame) -> None:
    for k, (start, own) in enumerate(rows.groupby("start", sort=False)):
        curve(ax, k, own["iterations"].clip(lower=NONE), own["residual"], f"from {_start(str(start))}", ls="", alpha=0.6)
    finish(ax, "iterations", "residual", "xy")


def _start(start: str) -> str:
    return "one given answer" if start == "given" else start


STUDY = Study((ranks, evidence), summary, plan, recorded)
