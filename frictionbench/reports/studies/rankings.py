"""The study of published rankings: theirs beside ours, and how evidence without friction comes about."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.problems.verdicts import Verdict
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look, looks
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.findings import (
    AGREES,
    DIFFERS,
    HEADS,
    LOOSE,
    OPEN,
    PAIRS,
    PARTLY,
    TIGHT,
    findings,
    needing,
    without_rank,
)
from frictionbench.reports.studies.lines import curve, finish
from frictionbench.reports.studies.numbers import share, wilson
from frictionbench.results.studies import RECORDED, StudyTables

START = {"resting": "given", "lifted": "zero"}  # the start that is told, of problems that need no friction
NONE = 0.5  # where no iteration is drawn, on a logarithmic axis


def account(found: StudyTables) -> Account:
    ranks, evidence = found["ranks"], found["evidence"]
    solves = [found[name] for name in ("solves", RECORDED) if name in found.tables]
    sets = [needing(rows) for rows in solves]
    short, cured = without_rank(ranks[ranks["method"] == "plain_newton"])
    least, _ = without_rank(ranks[ranks["method"] == "least_newton"])
    found.require((cured["rank"] == cured["unknowns"]).all(), "compliance gives full rank")
    found.require(least["solved"].sum() > short["solved"].sum(), "singular factors are one cause of failures without rank")
    rows = findings(sets, ranks)
    verdicts = [row[-1] for row in rows]
    missed = [own[~own["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])] for own in sets]
    sizes = [one.groupby("problem")["contacts"].first() for one in sets]
    told = {kind: evidence[(evidence["kind"] == kind) & (evidence["start"] == start)] for kind, start in START.items()}
    alike = {kind: _alike(own) for kind, own in told.items()}
    working = evidence[~evidence["idle"]]
    found.require(told["resting"]["idle"].all() and told["lifted"]["trivial"].all(), "what rests or is lifted off is idle")
    found.require((working["iterations"] > 0).all(), "no method is without iterations where friction is at work")
    left = [int(one.groupby("problem")[["idle", "trivial"]].first().any(axis=1).sum()) for one in solves]
    return Account(
        answer=f"Of {len(rows)} published findings {verdicts.count(AGREES)} are confirmed, {verdicts.count(PARTLY)} in part "
        f"and {verdicts.count(DIFFERS)} contradicted; {verdicts.count(OPEN)} need other problems. Where a start is the answer, "
        f"nearly all solvers show no iteration and one residual ({alike['lifted'][2]} of {alike['lifted'][1]}), which ranks "
        "nothing.",
        result=f"{sets[0]['problem'].nunique()} generated problems in space "
        + (
            f"and {sets[1]['problem'].nunique()} recorded ones, without {left[1]} that need no friction, are compared. "
            if len(sets) > 1
            else "are compared; the column of recorded problems needs a folder of them (--data). "
        )
        + f"Each solve may take a second: of {sum(map(len, missed))} that end without a solution of their model "
        f"{sum(int(one['verdict'].eq(Verdict.TIMEOUT).sum()) for one in missed)} are ended by that. "
        + f"A plain Newton's method with LU factors solves {share(int(short['solved'].sum()), len(short))} of the small "
        f"ones whose W lacks rank, {share(int(cured['solved'].sum()), len(cured))} of these with compliant contacts, and with "
        f"steps of least norm {share(int(least['solved'].sum()), len(least))} without these: singular factors are one cause. "
        f"A stack that rests is idle: from one given answer, {_said(alike['resting'])}. Lifted off, it is trivial: "
        f"from zero, {_said(alike['lifted'])}. Pushed, friction is at work, and all {working['solver'].nunique()} methods "
        "iterate, from zero as from the given answer.",
        limits="Of a published comparison its findings are tested, not its runs: other problems, one machine, and the "
        "implementations of this project and, where it is installed, of Siconos. "
        + f"Generated problems have up to {sizes[0].max()} contacts"
        + (
            f", recorded ones, what the folder held, up to {sizes[1].max()}, {_few(sizes[1])} of them below ten"
            if sizes[1:]
            else ""
        )
        + "; the published ones mostly tens to some hundreds, some sets thousands, some of deformable bodies; accelerated "
        "gradients are proposed for more. The question of convexity was asked there of Gauss-Seidel, here it is not. "
        "The residual is that of the worst contact, in the literature mostly a norm of all. Horak and Trinkle 2019 compare "
        "models in simulated motions, of which no problems were at hand: nothing is said of them. How particular published "
        "tables came about is not shown, only how such tables come about.",
        figures=(
            Figure(
                "profiles",
                "Share of the generated problems that a method solves within a multiple of the fastest method's time.",
                tuple(
                    Panel(f"to {tol:g}", partial(_profile, rows=sets[0], tol=tol, looks=_looks(sets[0])))
                    for tol in (LOOSE, TIGHT)
                ),
                _looks(sets[0]),
            ),
            Figure(
                "causes",
                "Left: share of problems solved to 1e-8 with 95 % intervals, where W lacks rank and on the same problems with "
                "compliant contacts. Right: iterations and residual of every method on a stack at rest; no iteration is drawn "
                "at the left edge.",
                (
                    Panel("with and without rank", partial(_solved, ranks=ranks)),
                    Panel("a stack at rest", partial(_evidence, rows=evidence[evidence["kind"] == "resting"])),
                ),
            ),
        ),
        table=(HEADS, *rows),
    )


def _few(contacts: "pd.Series[int]") -> int:
    return int((contacts < 10).sum())


def _alike(rows: pd.DataFrame) -> tuple[int, int, int, float]:
    """How many solvers have no iteration, of how many; how many of these have the commonest residual, and which it is."""
    none = rows.loc[rows["iterations"] == 0, "residual"]
    common = none.value_counts()
    return len(none), len(rows), int(common.iloc[0]), float(common.index[0])


def _said(alike: tuple[int, int, int, float]) -> str:
    none, of, same, value = alike
    return f"{none} of {of} methods report no iteration, and {same} of them the residual {value!r} to the last digit"


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
