"""Published findings on solvers beside what verified runs show: the rows of the table of the study of rankings."""

from collections.abc import Sequence

import pandas as pd

from frictionbench.results.verdicts import Verdict, measured

LOOSE, TIGHT = 1e-4, 1e-8
NSGS, PROXIMAL, NEWTON = ("nsgs", "friction_3d_nsgs"), ("proximal_newton", "friction_3d_prox"), ("friction_3d_nsn_ac",)
THEIRS = (*NSGS, *PROXIMAL, *NEWTON)  # the kinds of method of the published comparison
PAIRS = {"apgd_coulomb": "apgd", "interior_point": "relaxation_ip"}  # one method on Coulomb's law and on the relaxation
NEAR = 2.0  # times the fastest that a universal method would be within
HEADS = ("published finding", "in generated problems", "in recorded problems", "verdict")
AGREES, DIFFERS, PARTLY = "confirmed", "contradicted", "in part"

Row = tuple[str, ...]
Told = list[
    tuple[str, bool | None]
]  # by set of problems, what it shows, and whether that agrees; None: in part, or not measured


def findings(sets: list[pd.DataFrame], ranks: pd.DataFrame) -> list[Row]:
    """The table. sets: the runs on generated and, where given, on recorded problems; ranks: the study's table."""
    return [
        _universal(sets),
        _robust(sets),
        _short(sets),
        _proximal(sets),
        _full_rank(sets, ranks),
        _convexified(ranks),
        _relaxed(sets),
        _accelerated(sets),
    ]


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


def _fastest(rows: pd.DataFrame, tol: float, names: Sequence[str] | None = None) -> "pd.Series[int]":
    """By method, how many problems it solves in the least time."""
    own = rows[(rows["tol"] == tol) & rows["solved"]]
    own = own if names is None else own[own["name"].isin(names)]
    return own.loc[own.groupby("problem")["time"].idxmin(), "name"].value_counts()


def _row(finding: str, told: Told) -> Row:
    """A row of the table: what each set of problems shows, and whether that agrees; None: in part, or not measured."""
    texts = [text for text, _ in told] + ["needs --data"] * (2 - len(told))
    agree = {holds for _, holds in told}
    return finding, *texts, AGREES if agree == {True} else DIFFERS if agree == {False} else PARTLY


def _universal(sets: list[pd.DataFrame]) -> Row:
    told: Told = []
    for rows in sets:
        good = rows[rows["solved"]]
        near = good["time"] <= NEAR * good.groupby(["problem", "tol"])["time"].transform("min")
        of = len(rows[["problem", "tol"]].drop_duplicates())
        shares = near.groupby(good["name"]).sum() / of
        best = str(shares.idxmax())
        told.append((f"{best} is within {NEAR:g} times the fastest in {100 * shares[best]:.0f} % of cases", shares[best] < 0.9))
    return _row("No solver is best for all problems (Acary, Brémond and Huber 2018).", told)


def _robust(sets: list[pd.DataFrame]) -> Row:
    told: Told = []
    for rows in sets:
        done, of = _solved(rows, LOOSE, ("nsgs",))
        counts = _fastest(rows, LOOSE, THEIRS)
        mine, total = int(counts.reindex(list(NSGS)).fillna(0).sum()), int(counts.sum())
        robust, best = done >= 0.9 * of, mine > total / 2
        told.append((f"solves {done} of {of}, fastest of the paper's kinds on {mine} of {total}", _both(robust, best)))
    return _row("Gauss-Seidel is robust on rigid bodies and mostly fastest at 1e-4 (the same).", told)


def _short(sets: list[pd.DataFrame]) -> Row:
    told: Told = []
    for rows in sets:
        counts = [(name, *_solved(rows, TIGHT, (name,))) for name in NSGS]
        done, of = counts[0][1:]
        told.append((", ".join(f"{name} solves {done} of {of}" for name, done, of in counts if of), done < of / 2))
    return _row("It falls short of 1e-8 on most problems (the same).", told)


def _proximal(sets: list[pd.DataFrame]) -> Row:
    told: Told = []
    for rows in sets:
        done, of = _solved(rows, TIGHT, PROXIMAL[:1])
        others = max(_solved(rows, TIGHT, (name,))[0] for name in THEIRS if name not in PROXIMAL)
        counts = _fastest(rows, TIGHT, THEIRS)
        mine, total = int(counts.reindex(list(PROXIMAL)).fillna(0).sum()), int(counts.sum())
        text = f"solves {done} of {of}, the best of the other kinds {others}; fastest of these kinds on {mine} of {total}"
        told.append((text, _both(done > others, mine > total / 2)))
    return _row("The proximal point with Newton's method is best at 1e-8 (the same).", told)


def _full_rank(sets: list[pd.DataFrame], ranks: pd.DataFrame) -> Row:
    plain = ranks[ranks["method"] == "plain_newton"]
    short, cured = without_rank(plain)
    full = plain[(plain["compliance"] == 0) & ~plain["number"].isin(short["number"])]
    text = "; ".join(
        f"{_of(rows)} {kind}"
        for rows, kind in ((full, "with full rank"), (short, "without"), (cured, "of these with compliance"))
    )
    drops = bool(short["solved"].mean() < min(full["solved"].mean(), cured["solved"].mean()))
    told: Told = []
    for k, rows in enumerate(sets):
        theirs = rows[(rows["tol"] == TIGHT) & rows["name"].isin(NEWTON)]
        with_rank, lacking = theirs[theirs["redundancy"] == 0], theirs[theirs["redundancy"] > 0]
        said = (
            f"Siconos' {_of(with_rank)} with full rank, {_of(lacking)} without" if len(theirs) else "Siconos is not installed"
        )
        worse = bool(lacking["solved"].mean() < with_rank["solved"].mean()) if len(with_rank) and len(lacking) else None
        told.append((f"plain method: {text}; {said}", drops) if k == 0 else (said, worse))
    return _row("Nonsmooth Newton works where W has full rank and diverges where it has not (the same).", told)


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
    verdict = AGREES if rank and not convexity else DIFFERS if convexity and not rank else PARTLY
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


def _relaxed(sets: list[pd.DataFrame]) -> Row:
    told: Told = []
    for rows in sets:
        own = rows[(rows["tol"] == TIGHT) & (rows["name"] == "relaxation_ip")]
        done = own[own["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])]
        off = done[done["verdict"] == Verdict.RELAXED]
        median = f", by a median residual of {off['residual'].median():.1g}" if len(off) else ""
        told.append((f"{len(off)} of {len(done)} of its solutions break Coulomb's law{median}", len(off) > len(done) / 2))
    return _row("Convex relaxations widen the gap to reality (Le Lidec and others 2024).", told)


def _accelerated(sets: list[pd.DataFrame]) -> Row:
    told: Told = []
    for rows in sets:
        own = rows[(rows["tol"] == LOOSE) & rows["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])]
        times = own.pivot_table(index="problem", columns="name", values="time")
        ratio = (times["nsgs"] / times["apgd"]).dropna()
        told.append((f"{ratio.median():.2g} times as fast in the median, at most {ratio.max():.2g}", _tens(ratio)))
    return _row("Accelerated gradients are one or two orders faster than Gauss-Seidel (Mazhar and others 2015).", told)


def _tens(ratio: "pd.Series[float]") -> bool | None:
    """Whether it is true in the median; None where it is true of some."""
    return True if ratio.median() >= 10 else None if ratio.max() >= 10 else False


def _both(first: bool, second: bool) -> bool | None:
    return first if first == second else None
