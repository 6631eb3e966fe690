"""Which solver to choose: for each kind of problem, the solvers by mean time to a target, and the confidence in the first.

The mean is the weighted shifted geometric mean of reports.accuracy, with problems not solved charged the time limit (PAR1), of
solvers that ran in every class of the kind's problems; one that they skip is charged, too. Solvers without a mean come last
(docs/reading.md).

The lead is the mean of the second solver over that of the first. Its interval contains 95 % of DRAWS bootstrap samples, each of
scenes (for robots' steps, models), then of the problems of each drawn scene, stratum by stratum, then of the repeats of each
cell, whose median is its time. In each sample the lead is over the best of the RIVALS next solvers (docs/reading.md).
"""

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from frictionbench.reports import accuracy
from frictionbench.reports.drawing.text import percent, power, ratio, seconds
from frictionbench.reports.run import PORTFOLIO, Run
from frictionbench.results.conventions import COLD, WARM, RankBy, count
from frictionbench.results.hardness import HIGH_CONDITION

SMALL, MEDIUM = 10, 100  # contacts: the largest problems of these two kinds, a decade each
DRAWS = 1000  # bootstrap samples: 25 of them lie beyond each end of an interval
MEDIANS = 32  # resampled medians of the repeats of a cell; each sample uses one of them
RIVALS = 4  # solvers after the first with which it is compared in each sample
TOO_FEW = 5.5  # problems, by n_eff, below which the bootstrap gives no meaningful interval
CHARGES = (1, 2, 10)  # time limits charged for a problem not solved: PAR1, PAR2 and PAR10
LISTED = 8  # solvers listed for a kind of problem
GLOSS = {
    "too few to rank": f"the weights leave fewer than {TOO_FEW} effective problems, too few for an interval by resampling",
    "no clear winner": "the 95 % interval of the lead includes 1.00: other scenes, problems or repeats could reverse the order",
}


class Place(NamedTuple):
    """A solver's place in an order. law: what it solves instead of Coulomb's law. reached, unjudgeable: numbers of problems
    solved to the target, and of those in which rounding leaves it open. skipped, fastest: numbers of problems on which it did
    not run, and on which no solver is faster. mean, p50, p99, worst: times, s; common: the mean over the problems that all
    solvers with a mean solve. written: the share of form in its time. within: the share solved within the budget."""

    label: str
    law: str
    mean: float
    common: float
    reached: int
    unjudgeable: int
    skipped: int
    fastest: int
    written: float
    p50: float
    p99: float
    worst: float
    within: float

    @property
    def solved(self) -> str:
        return accuracy.solved_words(self.reached, self.unjudgeable)


class Choice(NamedTuple):
    """The solvers that ran in all classes of a kind, the fastest first. common: the number of problems that all solvers with a
    mean solve. outside: the number of solvers with a mean from outside libraries. interval: that of the lead, None with too few
    problems. orders: the first three by each of CHARGES."""

    places: list[Place]
    problems: int
    common: int
    outside: int
    interval: tuple[float, float] | None
    orders: dict[int, list[str]]

    @property
    def unclear(self) -> str:
        """Why no winner is named, as a key of GLOSS, or an empty text."""
        if self.interval is None:
            return "too few to rank"
        return "no clear winner" if self.lead is not None and round(self.interval[0], 2) <= 1 else ""

    @property
    def lead(self) -> float | None:
        """The mean of the second solver over that of the first; None without a second mean."""
        second = self.places[1].mean if len(self.places) > 1 else np.nan
        return second / self.places[0].mean if np.isfinite(second) else None


class Kind(NamedTuple):
    """A kind of problem: its name, its number of problems, and the choice at each target that some solver reaches. first:
    whether it is shown on the first screen. robots: the number of problems that are robots' steps."""

    name: str
    problems: int
    choices: dict[float, Choice]
    first: bool
    robots: int


def _kinds(run: Run) -> list[tuple[str, set[int], set[str], bool]]:
    """Return the kinds in the run: name, problems, the labels compared on them, and whether the first screen shows it."""
    facts = run.ranked.drop_duplicates("problem_id").set_index("problem_id")
    cold, warm = (set(run.rows.loc[run.rows["start"].isin(starts), "label"]) for starts in (["", COLD], [WARM]))
    started = set(run.rows.loc[run.rows["label"].isin(warm), "problem_id"])
    kinds = []
    wholes = [(where, facts[facts["dimension"] == dimension]) for dimension, where in accuracy.OVERALL.items()]
    robots = facts[facts["robot"]]
    wholes += [("robots' steps", robots)] if not any(robots.index.equals(whole.index) for _, whole in wholes) else []
    for where, problems_there in wholes:
        contacts = problems_there["contacts"]
        parts = {
            "one outcome": ~problems_there["several_outcomes"],
            f"up to {SMALL} contacts": contacts <= SMALL,
            f"{SMALL + 1} to {MEDIUM} contacts": (contacts > SMALL) & (contacts <= MEDIUM),
            f"more than {MEDIUM} contacts": contacts > MEDIUM,
            f"ill-conditioned, above {HIGH_CONDITION:.0e}".replace("e+0", "e"): problems_there["condition"] > HIGH_CONDITION,
        }
        kinds.append((where, set(problems_there.index), cold, True))
        kinds.append((f"{where}, warm starts", set(problems_there.index) & started, warm, True))
        some = {name: at for name, at in parts.items() if at.any() and not at.all()}
        kinds += [(f"{where}, {name}", set(problems_there.index[at]), cold, False) for name, at in some.items()]
    return [(name, problems, labels, first) for name, problems, labels, first in kinds if problems and labels]


def choices(run: Run, among: Collection[str] | None = None) -> list[Kind]:
    """Return the choice for each kind of problem. among: the labels to choose from; None for all."""
    kinds, robots = [], set(run.ranked.loc[run.ranked["robot"], "problem_id"])
    for name, problems, labels, first in _kinds(run):
        some = labels if among is None else labels & set(among)
        best = {target: choose(times, problems, some, run.budget, run.outside) for target, times in run.times.items()}
        reached = {target: one for target, one in best.items() if one}
        kinds.append(Kind(name, len(problems), reached, first, len(problems & robots)))
    return kinds


def choose(
    times: pd.DataFrame, problems: set[int], labels: set[str], budget: float | None = None, outside: Collection[str] = ()
) -> Choice | None:
    """Return the choice for these problems among these labels; None if none of them reaches the target on any problem.

    times: see reports.accuracy.times_to. budget: s. outside: the labels of outside libraries.
    """
    own = times[times["problem_id"].isin(problems) & times["label"].isin(labels)]
    charged = _table(own, "charged").reindex(sorted(problems)).dropna(axis=1)
    own = own[own["label"].isin(charged.columns)]
    if not own["reached"].any():
        return None
    reached = _table(own, "reached").reindex(charged.index).astype(bool)
    problem = own.drop_duplicates("problem_id").set_index("problem_id").reindex(charged.index)
    weight, groups = accuracy.weights(problem), own.groupby("label")
    facts = accuracy.percentiles(own, budget).join(groups[["reached", "unjudgeable", "skipped"]].sum())
    facts["law"], has_mean = accuracy.laws(facts.join(groups[["model", "dimension"]].first()), len(charged))
    facts["written"] = accuracy.share_of_form(own, ["label"])
    means = {n: charged.where(reached, n * charged).apply(accuracy.shifted_geometric_mean, weight=weight) for n in CHARGES}
    facts["mean"] = means[1].where(has_mean)
    shared = reached[facts.index[has_mean & (facts["reached"] > 0)]].all(axis=1)
    facts["common"] = charged[shared].apply(accuracy.shifted_geometric_mean, weight=weight[shared]) if shared.any() else np.nan
    facts["common"] = facts["common"].where(has_mean & (facts["reached"] > 0))
    facts["fastest"] = (charged.where(reached, np.inf).eq(charged.where(reached).min(axis=1), axis=0)).sum()
    facts = facts.sort_values(["mean", "reached"], ascending=[True, False], kind="stable")
    ranked = [label for label in facts.index if has_mean[label]]
    interval = None
    if accuracy.effective(weight.to_numpy()) >= TOO_FEW and ranked:
        interval = lead_interval(own, charged[ranked[: 1 + RIVALS]], problem)
    return Choice(
        [Place(label=str(label), **facts.loc[label].to_dict()) for label in facts.index],
        len(charged),
        int(shared.sum()),
        sum(label in outside for label in ranked if not facts["law"][label]),
        interval,
        {charge: list(mean[ranked].sort_values(kind="stable").index[:3]) for charge, mean in means.items()},
    )


def _table(times: pd.DataFrame, column: str) -> pd.DataFrame:
    """A row per problem and a column per label."""
    return times.set_index(["problem_id", "label"])[column].unstack()  # noqa: PD010 - a pivot_table would average


def lead_interval(times: pd.DataFrame, charged: pd.DataFrame, problem: pd.DataFrame) -> tuple[float, float]:
    """Return the ends of the 95 % interval of the lead of the first column over the best of the others.

    times: with the column repeats. charged: times or charges, s, with a row per problem and a column per label. problem: the
    cluster and the stratum of each row.
    """
    random = np.random.default_rng(0)
    drawn, rows = draw_problems(problem.assign(weight=accuracy.weights(problem)), random), np.arange(len(charged))
    repeats = times.set_index(["label", "problem_id"])["repeats"]
    means = np.empty((DRAWS, charged.shape[1]))
    for k, label in enumerate(charged.columns):
        medians = np.stack([_medians(one, random) for one in repeats[label].reindex(charged.index)], axis=1)
        logs = np.log(medians * charged[label].to_numpy() + accuracy.SHIFT)
        means[:, k] = (drawn * logs[random.integers(MEDIANS, size=drawn.shape), rows]).sum(axis=1)
    means = np.exp(means) - accuracy.SHIFT
    leads = means[:, 1:].min(axis=1, initial=np.inf) / means[:, 0]
    low, high = np.percentile(leads, [2.5, 97.5]) if means.shape[1] > 1 else (np.inf, np.inf)
    return float(low), float(high)


def draw_problems(problem: pd.DataFrame, random: np.random.Generator) -> accuracy.Array:
    """Return the weights (DRAWS, problems) of problems in bootstrap samples of clusters and of the problems of each stratum.

    problem: with cluster (see reports.run), stratum and weight.
    """
    clusters, weight = list(problem["cluster"].unique()), problem["weight"].to_numpy()
    copies = random.multinomial(len(clusters), np.full(len(clusters), 1 / len(clusters)), size=DRAWS)
    weights = np.zeros((DRAWS, len(problem)))
    for (cluster, _), at in sorted(problem.groupby(["cluster", "stratum"]).indices.items()):  # pandas does not sort them
        drawn = random.multinomial(len(at) * copies[:, clusters.index(cluster)], np.full(len(at), 1 / len(at)))
        weights[:, at] = drawn * weight[at].sum() / len(at)
    return weights / weights.sum(axis=1, keepdims=True)


def _medians(repeats: object, random: np.random.Generator) -> accuracy.Array:
    """Return medians of resampled repeats over the median of the repeats; 1 if a cell was timed once or not solved."""
    if not isinstance(repeats, np.ndarray) or len(repeats) < 2:
        return np.ones(MEDIANS)
    drawn = np.median(random.choice(repeats, size=(MEDIANS, len(repeats))), axis=1)
    return drawn / np.median(repeats)


def headline(ranked: Mapping[RankBy, list[Kind]], target: float) -> list[str]:
    """Return sentences for each kind on the first screen. ranked: the choices by each ranking; target: the tightest."""
    kinds_by_name = {by: {kind.name: kind for kind in kinds} for by, kinds in ranked.items()}
    names = [kind.name for kind in next(iter(ranked.values()), []) if kind.first]
    return [_headline({by: kinds[name] for by, kinds in kinds_by_name.items()}, target) for name in names]


def _headline(kinds: dict[RankBy, Kind], target: float) -> str:
    (first, one), (second, other) = kinds.items()
    part = "all robots' steps" if one.robots == one.problems else f"of which {one.robots} are robots' steps"
    robots = f" ({part})" if one.robots and not one.name.startswith("robots") else ""
    where = f"{one.name.capitalize()}, {count(one.problems, 'problem')}{robots}, to a verified residual of {power(target)}: "
    if target not in one.choices:
        return f"{where}no solver that ran in all their classes reaches it."
    by_first, by_second = one.choices[target], other.choices[target]
    if len(by_first.places) == 1 and not (only := by_first.places[0]).law:
        return f"{where}{only.label} solves {only.solved}, {first.words} with a mean of {seconds(only.mean, 3)}."
    same = by_first.orders[1] == by_second.orders[1] and by_first.unclear == by_second.unclear
    order = f"{second.words} the order of the first three is the same" if same else _speed(second, by_second)
    speed = f"{_speed(first, by_first)}; {order}"
    return f"{where}{dependable(by_first)}. {speed[0].upper()}{speed[1:]}.{_charges(by_first)}"


def dependable(choice: Choice) -> str:
    """Return a sentence on the solver that solves most, the fastest among equals, on those compared, and on the best single
    method if it is a portfolio."""
    exact = [place for place in choice.places if not place.law]
    if not exact:
        return "no solver of Coulomb's law ran in all their classes"
    ours = len([place for place in exact if np.isfinite(place.mean)]) - choice.outside
    outside = f"{count(choice.outside, 'outside solver')} of Coulomb's law"
    compared = f"{count(ours, 'own method')} and {outside}" if choice.outside else "our own methods"
    ordered = sorted(exact, key=lambda place: (-place.reached, place.mean))
    best, single = ordered[0], [place for place in ordered if not place.label.endswith(PORTFOLIO)]
    text = f"the most dependable choice among {compared} is {best.label}, {best.solved} of {choice.problems} solved"
    text += f", itself the fastest on {best.fastest:.0f}"
    if best not in single and single:
        text += f"; the best single method is {single[0].label}, {single[0].solved} of {choice.problems} solved"
        text += f" with a mean of {seconds(single[0].mean, 3)}"
    often = max(exact, key=lambda place: place.fastest)
    return text + (f"; most often the fastest is {often.label}, on {often.fastest:.0f}" if often is not best else "")


def _speed(by: RankBy, choice: Choice) -> str:
    """Return a sentence on the first solver: its mean, the share of form in it, its lead, and why it is no winner, if so."""
    best = choice.places[0]
    name = f"{best.label} ({best.law})" if best.law else best.label
    form = f" ({percent(best.written)} of it is form)" if by is RankBy.BODIES else ""
    mean = f"{by.words} {name} has the least mean, {seconds(best.mean, 3)}{form}"
    if ahead := _ahead(choice):
        return f"{mean}, {ahead}"
    return f"{mean}; {choice.unclear}" if choice.unclear else mean


def _ahead(choice: Choice) -> str:
    """Return the lead and its interval in words, or an empty text if one of them is missing."""
    if choice.interval is None or choice.lead is None:
        return ""
    ends = " to ".join(map(ratio, choice.interval)) + ")" + (f": {choice.unclear}" if choice.unclear else "")
    return f"{ratio(choice.lead)} times ahead of {choice.places[1].label} ({ends}"


def disturbed(run: Run, leads: bool = True) -> str:
    """Return sentences on the cells that waited for their core while they were timed, and on the leads by the shortest repeat
    of each cell, which waiting lengthens least; empty if none waited.

    Leaving out such cells would leave out problems, rather those with long cells, and whole strata.
    """
    rows = run.rows[run.rows["disturbed"].eq(True) & run.rows["solve_time"].notna()]
    if rows.empty:
        return ""
    times = run.times[run.outer_targets[-1]]
    shortest = [one.min() if isinstance(one, np.ndarray) and len(one) else np.nan for one in times["repeats"]]
    times = times.assign(charged=pd.Series(shortest, times.index).fillna(times["charged"]), repeats=None)
    found = [(name, choose(times, problems, labels)) for name, problems, labels, first in _kinds(run) if first and leads]
    texts = [f"{name}: {one.places[0].label} is {ahead}" for name, one in found if one and (ahead := _ahead(one))]
    text = f"Of {len(run.rows)} cells {len(rows)} shared or waited for their core while they were timed"
    text += f", {once} of them timed once" if (once := (rows["solve_times"].map(np.size) == 1).sum()) else ""
    return f"{text}. By the shortest repeat of each cell, {run.rank_by.words}, {'; '.join(texts)}." if texts else f"{text}."


def _charges(choice: Choice) -> str:
    """Return a sentence on the charges for unsolved problems that change the first three, or an empty text."""
    changed = [
        f"by PAR{charge} {', then '.join(order)}" for charge, order in choice.orders.items() if order != choice.orders[1]
    ]
    return f" Other charges for what is not solved change the first three: {'; '.join(changed)}." if changed else ""
