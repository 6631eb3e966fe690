"""Published findings on solvers beside what verified runs show: the rows of the table of the study of rankings."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from scipy.stats import fisher_exact

from frictionbench import Verdict
from frictionbench.problems import measured

LOOSE, TIGHT = 1e-4, 1e-8
NSGS, PROXIMAL, NEWTON = ("nsgs", "friction_3d_nsgs"), ("proximal_newton", "friction_3d_prox"), ("friction_3d_nsn_ac",)
THEIRS = (*NSGS, *PROXIMAL, *NEWTON)  # the kinds of method of the published comparison
PAIRS = {"apgd_coulomb": "apgd", "interior_point": "relaxation_ip"}  # one method on Coulomb's law and on the relaxation
PLAIN = {"plain_newton": "LU factors", "least_newton": "steps of least norm"}
NEAR = 2.0  # times the fastest that a universal method would be within
AGREES, DIFFERS, PARTLY, OPEN = "confirmed", "contradicted", "in part", "not tested"
CHANCE = 0.05  # the probability up to which a difference of shares is no chance
SIZES = (0, 10, 100, np.inf)  # contacts

Row = tuple[str, ...]
Shown = tuple[str, bool | None]  # what a set of problems shows, and whether that agrees; None: in part, or not measured


def findings(sets: list[pd.DataFrame], ranks: pd.DataFrame) -> list[Row]:
    """The table. sets: the runs on generated and, where given, on recorded problems; ranks: the study's table."""
    universal, robust, incomplete, proximal, relaxed = (_row(text, list(map(show, sets))) for text, show in SHOWN.items())
    return [universal, robust, incomplete, proximal, _full_rank(sets, ranks), _convexified(ranks), relaxed, _accelerated(sets)]


def without_rank(ranks: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The rows of problems whose own W lacks rank, and those of the same problems with compliant contacts."""
    own, made = ranks[ranks["compliance"] == 0], ranks[ranks["compliance"] > 0]
    short = own[own["rank"] < own["unknowns"]]
    return short, made[made["number"].isin(short["number"])]


def needing(solves: pd.DataFrame) -> pd.DataFrame:
    """Measured cells of problems in space that need friction, with their time, s; outside methods by their own name."""
    rows = solves[measured(solves) & (solves["dimension"] == 3) & ~solves["trivial"].eq(True) & ~solves["idle"].eq(True)]
    name = rows["variant"].str.extract(r"method=(\w+)")[0].fillna(rows["variant"])
    time = rows[["form_time", "setup_time", "solve_time"]].sum(axis=1)
    return rows.assign(name=name, time=time, solved=rows["verdict"] == Verdict.SOLVED)


def _solved(rows: pd.DataFrame, tol: float, names: Sequence[str]) -> tuple[int, int]:
    """How many cells of these methods are solved, and how many there are."""
    own = rows[(rows["tol"] == tol) & rows["name"].isin(names)]
    return int(own["solved"].sum()), len(own)


def _fastest(rows: pd.DataFrame, tol: float, kind: Sequence[str], among: Sequence[str]) -> tuple[int, int]:
    """On how many problems a method of the kind is the fastest among these, and on how many one of these solves."""
    own = rows[(rows["tol"] == tol) & rows["solved"] & rows["name"].isin(among)]
    first = own.loc[own.groupby("problem")["time"].idxmin(), "name"]
    return int(first.isin(kind).sum()), len(first)


def _row(finding: str, shown: Sequence[Shown]) -> Row:
    """A row of the table: what each set of problems shows, and whether they agree."""
    texts = [text for text, _ in shown] + ["needs --data"] * (2 - len(shown))
    agree = {holds for _, holds in shown}
    return finding, *texts, AGREES if agree == {True} else DIFFERS if agree == {False} else PARTLY


def _universal(rows: pd.DataFrame) -> Shown:
    good = rows[rows["solved"]]
    near = good["time"] <= NEAR * good.groupby(["problem", "tol"])["time"].transform("min")
    shares = near.groupby(good["name"]).sum() / len(rows[["problem", "tol"]].drop_duplicates())
    best = str(shares.idxmax())
    return f"{best} is within {NEAR:g} times the fastest in {100 * shares[best]:.0f} % of cases", bool(shares[best] < 0.9)


def _robust(rows: pd.DataFrame) -> Shown:
    counts = [(name, *_solved(rows, LOOSE, (name,))) for name in NSGS]
    robust = all(done >= 0.9 * of for _, done, of in counts)
    siconos = [name for name in THEIRS if name.startswith("friction")]
    first = [_fastest(rows, LOOSE, NSGS, among) for among in (THEIRS, siconos)]
    text = f"{_solves(counts)}; one of them is the fastest of the paper's kinds on {first[0][0]} of {first[0][1]}"
    text += f", Siconos' of Siconos' on {first[1][0]} of {first[1][1]}" if first[1][1] else ""
    return text, _both(robust, all(mine > total / 2 for mine, total in first if total))


def _solves(counts: Sequence[tuple[str, int, int]]) -> str:
    return ", ".join(f"{name} solves {done} of {of}" for name, done, of in counts if of)


def _incomplete(rows: pd.DataFrame) -> Shown:
    counts = [(name, *_solved(rows, TIGHT, (name,))) for name in NSGS]
    short = {done < of for _, done, of in counts if of}
    return _solves(counts), short.pop() if len(short) == 1 else None


def _proximal(rows: pd.DataFrame) -> Shown:
    done, of = _solved(rows, TIGHT, PROXIMAL[:1])
    others = max(_solved(rows, TIGHT, (name,))[0] for name in THEIRS if name not in PROXIMAL)
    mine, total = _fastest(rows, TIGHT, PROXIMAL, THEIRS)
    text = f"{PROXIMAL[0]} solves {done} of {of}, the best other {others}; this kind is first on {mine} of {total}"
    return text, _both(done > others, mine > total / 2)


def _relaxed(rows: pd.DataFrame) -> Shown:
    own = rows[(rows["tol"] == TIGHT) & (rows["name"] == "relaxation_ip")]
    done = own[own["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])]
    off = done[done["verdict"] == Verdict.RELAXED]
    median = f", by a median residual of {off['residual'].median():.1g}" if len(off) else ""
    text = f"{len(off)} of {len(done)} answers of relaxation_ip break Coulomb's law{median}; its cost: see relaxation"
    return text, None if len(off) > len(done) / 2 else False  # of reality the problems tell nothing


SHOWN: dict[str, Callable[[pd.DataFrame], Shown]] = {
    "No solver is best for all problems (Acary, Brémond and Huber 2018).": _universal,
    "Gauss-Seidel is robust on rigid bodies and mostly fastest at 1e-4 (the same).": _robust,
    "It does not solve all problems to 1e-8 within the time limit (the same).": _incomplete,
    "The proximal point with Newton's method is best at 1e-8 on most sets of rigid bodies (the same).": _proximal,
    "Approximations common in robotics can widen the gap to reality (Le Lidec and others 2024).": _relaxed,
}


def _full_rank(sets: list[pd.DataFrame], ranks: pd.DataFrame) -> Row:
    parts, drops = [], []
    for method, step in PLAIN.items():
        plain = ranks[ranks["method"] == method]
        short, cured = without_rank(plain)
        full = plain[(plain["compliance"] == 0) & ~plain["number"].isin(short["number"])]
        parts.append(f"with {step} {_of(short)} without full rank, {_of(cured)} of these with compliance")
        drops.append(bool(short["solved"].mean() < cured["solved"].mean()))
        parts += [f"{_of(full)} with full rank, of at most {full['contacts'].max()} contacts"] * (method == list(PLAIN)[-1])
    shown: list[Shown] = []
    for k, rows in enumerate(sets):
        theirs = rows[(rows["tol"] == TIGHT) & rows["name"].isin(NEWTON)]
        lost = theirs["redundancy"].fillna(theirs["contacts"] * theirs["dimension"] - theirs["velocities"])  # at least
        with_rank, lacking = theirs[lost <= 0], theirs[lost > 0]
        said = (
            f"Siconos' {_of(with_rank)} with full rank, {_of(lacking)} without" if len(theirs) else "Siconos is not installed"
        )
        worse = _rarer(lacking, with_rank) if len(with_rank) and len(lacking) else None
        if k == 0:
            shown.append((f"plain method, {'; '.join(parts)}; {said}", _both(*drops)))
        else:
            shown.append((said, worse))
    finding = (
        "Nonsmooth Newton is efficient where W has full rank or contacts are few, and generally diverges where neither holds"
    )
    return _row(f"{finding} (the same).", shown)


def _rarer(rows: pd.DataFrame, other: pd.DataFrame) -> bool | None:
    """Whether rows are solved more rarely than other; None where that may be chance (Fisher's exact test)."""
    counts = [[int(own["solved"].sum()), int((~own["solved"]).sum())] for own in (rows, other)]
    return True if fisher_exact(counts, "less").pvalue <= CHANCE else None


def _of(rows: pd.DataFrame) -> str:
    return f"{int(rows['solved'].sum())} of {len(rows)}"


def _convexified(ranks: pd.DataFrame) -> Row:
    own = ranks[ranks["compliance"] == 0]
    short, cured = without_rank(ranks)
    heavier = {name: _work(_method(own, name), _method(own, relaxed)) for name, relaxed in PAIRS.items()}
    softer = {name: _work(_method(cured, name), _method(short, name)) for name in ("nsgs", *PAIRS)}
    text = (
        f"median work on Coulomb's law over that on the relaxation: {_numbers(heavier)}; with rank restored over without: "
        f"{_numbers(softer)}"
    )
    convexity, rank = max(heavier.values()) > 1.5, max(softer.values()) < 1 / 1.5
    verdict = {(True, False): AGREES, (False, True): DIFFERS, (True, True): PARTLY, (False, False): OPEN}[rank, convexity]
    finding = (
        "Rank deficiency, not the lack of convexity alone, is the main difficulty; convexifying helps on some sets (the same)."
    )
    return finding, text, "not repeated", verdict


def _method(rows: pd.DataFrame, name: str) -> pd.DataFrame:
    return rows[rows["method"] == name].set_index("number")


def _work(one: pd.DataFrame, other: pd.DataFrame) -> float:
    """The median ratio of work, where both are solved."""
    return float((one["work"] / other["work"])[one["solved"] & other["solved"]].median())


def _numbers(ratios: dict[str, float]) -> str:
    return ", ".join(f"{name} {ratio:.2g}" for name, ratio in ratios.items())


def _accelerated(sets: list[pd.DataFrame]) -> Row:
    shown = []
    for rows in sets:
        own = rows[(rows["tol"] == LOOSE) & rows["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])]
        times = own.pivot_table(index="problem", columns="name", values="time")
        ratio = (times["nsgs"] / times["apgd"]).dropna()
        contacts = own.groupby("problem")["contacts"].first().reindex(ratio.index)
        groups = ratio.groupby(
            pd.cut(contacts, SIZES, right=False, labels=["below 10", "10 to 99", "100 and more"]), observed=True
        )
        parts = (f"{group.median():.2g} with {size} contacts ({len(group)})" for size, group in groups)
        shown.append("apgd's speed over nsgs', median: " + ", ".join(parts))
    finding = "Accelerated gradients are one or two orders faster than Gauss-Seidel in large systems (Mazhar and others 2015)."
    return finding, *shown, *["needs --data"] * (2 - len(shown)), OPEN


def _both(first: bool, second: bool) -> bool | None:
    return first if first == second else None
