"""What do published rankings look like under one verifier? Methods of published comparisons, measured again."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from scipy.stats import fisher_exact, hypergeom

import frictionbench as fb
from frictionbench import Verdict
from frictionbench.harness.plans import families
from frictionbench.harness.plans.plan import Plan
from frictionbench.problems import keep_contacts, measured
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look, looks
from frictionbench.solvers import find, solve
from studies.study import Row, Study, Summary, Tables, finish, listing, share

LOOSE, TIGHT = 1e-4, 1e-8
NSGS, PROXIMAL, NEWTON = ("nsgs", "friction_3d_nsgs"), ("proximal_newton", "friction_3d_prox"), ("friction_3d_nsn_ac",)
THEIRS = (*NSGS, *PROXIMAL, *NEWTON)  # the kinds of method in Acary, Brémond and Huber 2018, ours and Siconos'
RELAXED = ("apgd", "relaxation_ip")  # on the convex relaxation
OTHERS = ("interior_point", "staggered", "nncg", "admm_coulomb", "apgd_coulomb", *RELAXED)
SMALL = families.sources(families.SPACE_ONE, families.SPACE_SMALL, families.SPACE_MEDIUM)
LARGER = families.halves(families.SPACE_LARGE)
NEAR_FASTEST = 2.0  # a universal method would be within this factor of the fastest time
CHANCE = 0.05  # significance level for differences of shares
CONFIRMED, PARTLY, CONTRADICTED, UNDECIDED = VERDICTS = ("confirmed", "in part", "contradicted", "undecided")
COUNTED = (CONFIRMED, PARTLY, CONTRADICTED)  # the verdicts that counts of these problems can give

Shown = tuple[str, str]  # the result as text, and the verdict
Rows = list[tuple[str, str, str, str]]  # the finding, the result, the verdicts that are possible, and the verdict


def plan() -> Plan:
    """Return the plan: problems in space with times, for the kinds of method in the published comparisons."""
    theirs = (f"siconos[method={name}]" if name.startswith("friction") else name for name in THEIRS)
    return Plan(
        suite="study rankings",
        sources=tuple(replace(source, repeats=3) for source in (*SMALL, *LARGER)),
        solvers=(*theirs, *OTHERS),
        tolerances=(1e-4, 1e-8),
        time_limit=1.0,
    )


def ranks(contacts: Iterable[int] = (20, 80), draws: int = 30) -> Iterator[Row]:
    """Nonsmooth Newton, if Siconos is installed, on as many contacts of random bodies with and without full rank."""
    spec = f"siconos[method={NEWTON[0]}]"
    for count, seed in product(() if find(spec)[0].missing else contacts, range(draws)):
        # Half of the contacts of twice as many bodies leave bodies free: their rows are independent.
        spread = keep_contacts(fb.instance("random_bodies", contacts=2 * count, seed=seed), list(range(count)))
        for problem in (spread, fb.instance("random_bodies", contacts=count, seed=seed)):
            solved = fb.residual(problem, solve(problem, spec, tol=TIGHT).impulse) <= TIGHT
            yield {"contacts": count, "lost": 3 * count - np.linalg.matrix_rank(problem.W.toarray()), "solved": solved}


def summary(tables: Tables) -> Summary:
    ranks = tables["ranks"]
    solves = needing(tables["solves"])
    rows = _rows(solves)
    added = solves["scene"].eq("packed_spheres") & (solves["contacts"] <= 100)  # by the current version of the study
    without = _rows(solves[~added])
    one_less = [_rows(solves[solves["problem"] != problem]) for problem in solves["problem"].unique()]
    tally = [(verdict, sum(row[-1] == verdict for row in rows)) for verdict in VERDICTS]
    problems = solves["problem"].nunique()
    missed = solves[~solves["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])]
    numbers = {
        "rows": rows,
        "without": without,
        "added": solves.loc[added, "problem"].nunique(),
        "changed": _changed(rows, [without]),
        "single": _changed(rows, one_less),
        "tally": listing([f"{verdict} {number}" for verdict, number in tally if number]),
        "generated": problems,
        "half": share(problems // 2, problems),
        "missed": len(missed),
        "timeouts": int(missed["verdict"].eq(Verdict.TIMEOUT).sum()),
        "largest": solves["contacts"].max(),
        "ranks": [
            (count, "without" if lacks else "with", share(rows["solved"].sum(), len(rows)), rows["lost"].agg(["min", "max"]))
            for (count, lacks), rows in (ranks.groupby(["contacts", ranks["lost"] > 0]) if len(ranks) else ())
        ],
        "alike": len(ranks) and ranks["solved"].all(),
        "slowest": f"{1000 * solves[solves['solved']].groupby(['problem', 'tol'])['time'].min().max():.2g}",
    }
    shown = looks(name for name in solves["name"].unique() if name not in RELAXED)  # the methods for Coulomb's law
    panels = [Panel(f"to {tol:g}", partial(_profile, rows=solves, tol=tol, looks=shown)) for tol in (LOOSE, TIGHT)]
    return Summary(numbers, {"profiles": panels}, shown)


def _rows(solves: pd.DataFrame) -> Rows:
    shown = [(finding, show(solves), ", ".join(possible)) for finding, (show, possible) in SHOWN.items()]
    return [(finding, result[0], possible, result[1]) for finding, result, possible in shown if result]


def _changed(rows: Rows, others: Sequence[Rows]) -> str:
    """Return the numbers, from 1, of the rows whose verdict is another in some of the others; none if there are none."""
    return listing([str(k + 1) for k in range(len(rows)) if any(other[k][-1] != rows[k][-1] for other in others)])


def _profile(ax: Axes, rows: pd.DataFrame, tol: float, looks: dict[str, Look]) -> None:
    rows_to_tol = rows[(rows["tol"] == tol) & rows["name"].isin(list(looks))]
    best = rows_to_tol[rows_to_tol["solved"]].groupby("problem")["time"].min()
    for name, mine in rows_to_tol.groupby("name"):
        solved = mine[mine["solved"]]
        ratio = np.sort(solved["time"].to_numpy(float) / best[solved["problem"]].to_numpy(float))
        x, done = np.concatenate([[1], ratio, [1e4]]), np.minimum(np.arange(len(ratio) + 2), len(ratio))
        ax.step(x, done / rows_to_tol["problem"].nunique(), where="post", **looks[str(name)].line | {"marker": ""})
    finish(ax, "times the fastest", "share of problems", "x", xlim=(1, 1e3), ylim=(0, 1.03))


def needing(solves: pd.DataFrame) -> pd.DataFrame:
    """Return measured cells of problems in space that need friction, with their time, s, and outside methods' own names."""
    rows = solves[measured(solves) & (solves["dimension"] == 3) & ~solves["trivial"].eq(True) & ~solves["idle"].eq(True)]
    name = rows["variant"].str.extract(r"method=(\w+)")[0].fillna(rows["variant"])
    time = rows[["form_time", "setup_time", "solve_time"]].sum(axis=1)
    return rows.assign(name=name, time=time, solved=rows["verdict"] == Verdict.SOLVED)


def _solved(rows: pd.DataFrame, tol: float, names: Sequence[str]) -> tuple[int, int]:
    """Return how many cells of these methods are solved, and how many there are."""
    rows_to_tol = rows[(rows["tol"] == tol) & rows["name"].isin(names)]
    return int(rows_to_tol["solved"].sum()), len(rows_to_tol)


def _fastest(rows: pd.DataFrame, tol: float, kind: Sequence[str], among: Sequence[str]) -> tuple[int, int]:
    """Return on how many problems a method of the kind is the fastest of these, and how many problems these solve."""
    rows_to_tol = rows[(rows["tol"] == tol) & rows["solved"] & rows["name"].isin(among)]
    first = rows_to_tol.loc[rows_to_tol.groupby("problem")["time"].idxmin(), "name"]
    return int(first.isin(kind).sum()), len(first)


def _universal(rows: pd.DataFrame) -> Shown:
    good = rows[rows["solved"]]
    near = good["time"] <= NEAR_FASTEST * good.groupby(["problem", "tol"])["time"].transform("min")
    counts, cases = near.groupby(good["name"]).sum(), len(rows[["problem", "tol"]].drop_duplicates())
    text = f"no method is within {NEAR_FASTEST:g} times the fastest in more than {counts.max()} of {cases} cases"
    return text, CONFIRMED if counts.max() < 0.9 * cases else CONTRADICTED


def _robust(rows: pd.DataFrame) -> Shown:
    counts = [(name, *_solved(rows, LOOSE, (name,))) for name in NSGS]
    robust = all(done >= 0.9 * of for _, done, of in counts)
    siconos = [name for name in THEIRS if name.startswith("friction")]
    first = [_fastest(rows, LOOSE, NSGS, among) for among in (THEIRS, siconos)]
    text = ", ".join(f"{name} solves {done} of {of}" for name, done, of in counts if of)
    text += f"; one of them is the fastest of the paper's kinds on {first[0][0]} of {first[0][1]}"
    text += f", of Siconos' own kinds on {first[1][0]} of {first[1][1]}" if first[1][1] else ""
    return text, _both(robust, all(mine > total / 2 for mine, total in first if total))


def _proximal(rows: pd.DataFrame) -> Shown:
    done, of = _solved(rows, TIGHT, PROXIMAL[:1])
    others = max(_solved(rows, TIGHT, (name,))[0] for name in THEIRS if name not in PROXIMAL)
    mine, total = _fastest(rows, TIGHT, PROXIMAL, THEIRS)
    text = f"{PROXIMAL[0]} solves {done} of {of}, the best other {others}; this kind is first on {mine} of {total}"
    return text, _both(done > others, mine > total / 2)


def _relaxed(rows: pd.DataFrame) -> Shown:
    of_relaxation = rows[(rows["tol"] == TIGHT) & (rows["name"] == "relaxation_ip")]
    done = of_relaxation[of_relaxation["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])]
    off = done[done["verdict"] == Verdict.RELAXED]
    median = f", by a median residual of {off['residual'].median():.1g}" if len(off) else ""
    text = f"{len(off)} of {len(done)} answers of relaxation_ip break Coulomb's law{median}; its cost: see relaxation"
    return f"{text}; the gap to reality is not measured", UNDECIDED


def _full_rank(rows: pd.DataFrame) -> Shown | None:
    """Test by Fisher's exact test whether rank-deficient problems are solved more rarely; None if Siconos is not installed."""
    theirs = rows[(rows["tol"] == TIGHT) & rows["name"].isin(NEWTON)]
    if theirs.empty:
        return None
    lost = theirs["redundancy"].fillna(theirs["contacts"] * theirs["dimension"] - theirs["velocities"])  # at least
    counts = [[int(part["solved"].sum()), int((~part["solved"]).sum())] for part in (theirs[lost > 0], theirs[lost <= 0])]
    (lacking, _), (ranked, _) = counts
    late, missed = theirs["verdict"].eq(Verdict.TIMEOUT).sum(), (~theirs["solved"]).sum()
    p = fisher_exact(counts, "less").pvalue
    least = hypergeom(len(theirs), missed, sum(counts[1])).pmf(0)  # where none of full rank is missed
    text = f"Siconos' {ranked} of {sum(counts[1])} with full rank, {lacking} of {sum(counts[0])} without"
    text += f"; {late} of the {missed} missed end by the limit, which is no divergence"
    text += f"; Fisher's one-sided exact test has p = {p:.2g}, with {missed} missed it cannot be below {least:.2g}"
    return text, UNDECIDED if p > CHANCE else PARTLY if late > missed / 2 else CONFIRMED


def _both(first: bool, second: bool) -> str:
    return PARTLY if first != second else CONFIRMED if first else CONTRADICTED


SHOWN: dict[str, tuple[Callable[[pd.DataFrame], Shown | None], Sequence[str]]] = {  # and which verdicts it can have
    "No solver is best for all problems (Acary, Brémond and Huber 2018).": (_universal, (CONFIRMED, CONTRADICTED)),
    "Gauss-Seidel is robust on rigid bodies and mostly fastest at 1e-4 (the same).": (_robust, COUNTED),
    "The proximal point with Newton's method is best at 1e-8 on most sets of rigid bodies (the same).": (_proximal, COUNTED),
    "Nonsmooth Newton is efficient where W has full rank or contacts are few, and generally diverges where neither holds "
    "(the same).": (_full_rank, (CONFIRMED, PARTLY, UNDECIDED)),
    "Approximations common in robotics can widen the gap to reality (Le Lidec and others 2024).": (_relaxed, (UNDECIDED,)),
}

STUDY = Study((ranks,), summary, plan)
