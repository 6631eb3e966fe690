"""Which solver to choose: for each kind of problem the solvers ordered by their mean time to a target, and the win rate of the
first.

The mean is the weighted shifted geometric mean of reports.accuracy, with problems not solved charged the time limit. Only
solvers that ran on every problem of the kind are ordered, so that all are compared on the same problems; plane and space are
different kinds. The lead is the mean of the second solver over that of the first. The win rate is the share of DRAWS bootstrap
samples in which the same solver is first; a sample draws n_eff problems with the probabilities of their weights. Problems of
one scene are similar, so the win rate applies to problems like these. Of too few problems no solver is the winner. `headline`
says it in a sentence for the plane and one for space, the first of the report. `left_out`
tells which scenes decide a ranking: the order of the solvers, at the finest target, when each scene is left out in turn.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from frictionbench.reports.accuracy import HUNDRED, OVERALL, SHIFT, effective, percentiles, share_of_form, weights
from frictionbench.reports.drawing.text import ahead, count, percent, power, seconds
from frictionbench.reports.run import Run
from frictionbench.results.conventions import COLD, WARM, RankBy, law
from frictionbench.results.hardness import ILL

SMALL, MEDIUM = 10, 100  # contacts: the largest problems of these two kinds, a decade each
DRAWS = 1000  # bootstrap samples: the standard error of a win rate is below 2 %
FEW = 5  # problems, by n_eff; of so few the bootstrap gives no meaningful win rate, and none is the winner
MAJORITY = 0.5  # the least win rate of a winner


class Place(NamedTuple):
    """A solver in an order. law: what it solves in place of Coulomb's law; reached: the number of problems solved to the
    target; form: the share of form in form, setup and solve; within: the share of the problems solved within the budget; times
    in s."""

    label: str
    law: str
    mean: float
    reached: int
    form: float
    p50: float
    p99: float
    worst: float
    within: float


class Choice(NamedTuple):
    """The solvers that ran on all problems of a kind, the fastest first. win_rate: of the first, None where the problems are
    too few to name a winner; below MAJORITY none is named either."""

    places: list[Place]
    problems: int
    win_rate: float | None

    @property
    def winner(self) -> Place | None:
        return None if self.unclear else self.places[0]

    @property
    def unclear(self) -> str:
        """Why no winner is named, or ""."""
        if self.win_rate is None:
            return "too few to rank"
        return "no clear winner" if self.win_rate < MAJORITY else ""

    @property
    def lead(self) -> float | None:
        """The mean of the second over that of the first; None without a second."""
        return self.places[1].mean / self.places[0].mean if len(self.places) > 1 else None

    @property
    def tail(self) -> bool:
        """Whether the problems are enough for a 99th percentile."""
        return self.problems >= HUNDRED

    @property
    def order(self) -> list[str]:
        """The labels of the first three."""
        return [place.label for place in self.places[:3]]


class Kind(NamedTuple):
    """A kind of problem: its name, its number of problems, and the choice at each target that some solver reaches."""

    name: str
    problems: int
    choices: dict[float, Choice]


def kinds(run: Run) -> list[tuple[str, set[int], set[str]]]:
    """Of each kind that the run has: its name, its problems, and the labels that are compared on them."""
    facts = run.ranked.drop_duplicates("problem_id").set_index("problem_id")
    cold, warm = (set(run.rows.loc[run.rows["start"].isin(starts), "label"]) for starts in (["", COLD], [WARM]))
    started = set(run.rows.loc[run.rows["label"].isin(warm), "problem_id"])
    found = []
    for dimension, where in OVERALL.items():
        own = facts[facts["dimension"] == dimension]
        contacts = own["contacts"]
        parts = {
            f"up to {SMALL} contacts": contacts <= SMALL,
            f"{SMALL + 1} to {MEDIUM} contacts": (contacts > SMALL) & (contacts <= MEDIUM),
            f"more than {MEDIUM} contacts": contacts > MEDIUM,
            f"ill-conditioned, above {ILL:.0e}".replace("e+0", "e"): own["condition"] > ILL,
        }
        found.append((where, set(own.index), cold))
        found += [(f"{where}, {name}", set(own.index[at]), cold) for name, at in parts.items() if at.any() and not at.all()]
        found.append((f"{where}, warm starts", set(own.index) & started, warm))
    return [(name, problems, labels) for name, problems, labels in found if problems and labels]


def choices(run: Run, among: set[str] | None = None) -> list[Kind]:
    """The choice for each kind of problem. among: the labels to choose from; None for all."""
    found = []
    for name, problems, labels in kinds(run):
        some = labels if among is None else labels & among
        best = {target: choose(times, problems, some, run.budget) for target, times in run.times.items()}
        found.append(Kind(name, len(problems), {target: one for target, one in best.items() if one}))
    return found


def choose(times: pd.DataFrame, problems: set[int], labels: set[str], budget: float | None = None) -> Choice | None:
    """The choice for these problems among these labels; None if none of them reaches the target on any problem.

    times: see reports.accuracy.times_to. budget: s.
    """
    own = times[times["problem_id"].isin(problems) & times["label"].isin(labels)]
    logs, weight = compared(own, problems)
    if not own["reached"].any() or logs.empty:
        return None
    means = (weight @ logs).sort_values(kind="stable")
    own = own[own["label"].isin(means.index)]
    groups = own.groupby("label")
    facts = percentiles(own, budget).assign(reached=groups["reached"].sum(), form=share_of_form(own, ["label"]))
    facts["law"] = [law(*what) for what in groups[["model", "dimension"]].first().reindex(facts.index).itertuples(index=False)]
    facts["mean"] = np.exp(means) - SHIFT
    places = [Place(label=str(label), **facts.loc[label].to_dict()) for label in means.index]
    return Choice(places, len(logs), _win_rate(logs[means.index].to_numpy(), weight.to_numpy()))


def compared(times: pd.DataFrame, problems: set[int]) -> tuple[pd.DataFrame, "pd.Series[float]"]:
    """The logarithms of the times plus s, a row per problem and a column per label that ran on all of the problems; and the
    weights of the problems. times: see reports.accuracy.times_to."""
    table = times.pivot_table(index="problem_id", columns="label", values="charged")
    table = table.reindex(sorted(problems)).dropna(axis=1)
    facts = times.drop_duplicates("problem_id").set_index("problem_id").reindex(table.index)
    return np.log(table + SHIFT), weights(facts)


def too_few(weight: NDArray[np.float64]) -> bool:
    """Whether the problems of these weights are FEW or less."""
    return effective(weight) < FEW + 0.5


def _win_rate(logs: NDArray[np.float64], weight: NDArray[np.float64]) -> float | None:
    """The share of weighted bootstrap samples in which the first column is least; None for FEW problems or less."""
    if too_few(weight):
        return None
    drawn = np.random.default_rng(0).multinomial(round(effective(weight)), weight / weight.sum(), size=DRAWS)
    return float(np.mean(np.argmin(drawn @ logs, axis=1) == 0))


def headline(ranked: dict[RankBy, list[Kind]], overall: list[str], target: float) -> list[str]:
    """A sentence for each class of all problems of a dimension. ranked: the choices by each ranking; target: the finest."""
    found = {by: {kind.name: kind for kind in kinds} for by, kinds in ranked.items()}
    return [
        _headline({by: kinds[name] for by, kinds in found.items()}, target)
        for name in overall
        if all(name in one for one in found.values())
    ]


def differs(ranked: dict[RankBy, list[Kind]], target: float) -> bool:
    """Whether the two rankings have another winner, or another order of the first three, for some kind of problem."""
    return any(
        one.choices[target].order != other.choices[target].order
        for one, other in zip(*ranked.values(), strict=True)
        if target in one.choices
    )


def _headline(kinds: dict[RankBy, Kind], target: float) -> str:
    (first, one), (second, other) = kinds.items()
    where = f"{one.name.capitalize()}, {count(one.problems, 'problem')}, to a verified residual of {power(target)}: "
    if target not in one.choices:
        return f"{where}no solver that ran on all of them reaches it."
    mine, theirs = one.choices[target], other.choices[target]
    if mine.winner and theirs.winner and mine.order == theirs.order:
        same = f"{second.words} the first three are the same, the fastest {_figures(second, theirs)}"
        return f"{where}{_winner(first, mine)}; {same}."
    if mine.unclear == theirs.unclear != "":
        return f"{where}{mine.unclear}."
    return f"{where}{_winner(first, mine)}; {_winner(second, theirs)}."


def _winner(by: RankBy, choice: Choice) -> str:
    best = choice.winner
    if best is None:
        return f"{by.words} {choice.unclear}"
    name = f"{best.label} ({best.law})" if best.law else best.label
    return f"{by.words} {name} is the fastest, {_figures(by, choice)}"


def _figures(by: RankBy, choice: Choice) -> str:
    """The mean of the first, the share of form in it, how many problems it solved, and how far it is ahead of the second."""
    best = choice.places[0]
    form = f", {percent(best.form)} of the time form" if by is RankBy.BODIES else ""
    mean = f"with a mean of {seconds(best.mean)}{form}, {best.reached} of {choice.problems} solved"
    return mean + (f", {ahead(choice.lead, choice.places[1].label)}" if choice.lead else "")


class LeftOut(NamedTuple):
    """A scene: its share of the weight, and whether without it the winner, and the order of the first three, are the same."""

    scene: str
    weight: float
    winner: str
    same_winner: bool
    same_order: bool


def without_scenes(run: Run) -> dict[str, list[LeftOut]]:
    """By class of all problems of a dimension, a line for each scene; none where they are too few to rank, or of one scene."""
    times = run.times[min(run.times)]
    return {name: _lines(times, problems, labels) for name, problems, labels in kinds(run) if name in run.overall}


def _lines(times: pd.DataFrame, problems: set[int], labels: set[str]) -> list[LeftOut]:
    own = times[times["problem_id"].isin(problems) & times["label"].isin(labels)]
    logs, weight = compared(own, problems)
    facts = own.drop_duplicates("problem_id").set_index("problem_id").reindex(logs.index)
    if too_few(weight.to_numpy()) or logs.shape[1] < 2 or facts["scene"].nunique() < 2:
        return []
    whole = _order(logs, weight)
    found = []
    for scene in facts["scene"].unique():
        rest = facts[facts["scene"] != scene]
        order = _order(logs.loc[rest.index], weights(rest))
        share = float(weight[facts["scene"] == scene].sum())
        found.append(LeftOut(scene, share, order[0], order[0] == whole[0], order == whole))
    return sorted(found, key=lambda one: -one.weight)


def _order(logs: pd.DataFrame, weight: "pd.Series[float]") -> list[str]:
    return list((weight @ logs).nsmallest(3).index)


def deciding_scenes(by_ranking: Mapping[RankBy, Mapping[str, list[LeftOut]]]) -> list[str]:
    """Which scenes decide the rankings of each class, in words. by_ranking: left_out of the run ranked by each time."""
    lines = [_families(name, lines, by) for by, found in by_ranking.items() for name, lines in found.items()]
    return [line for line in lines if line]


def _families(name: str, lines: list[LeftOut], by: RankBy) -> str:
    """Which scenes decide the ranking of a class, in words."""
    if not lines:
        return ""
    where = f"{name.capitalize()}, {by.words}"
    winners = [f"{one.scene} (then {one.winner})" for one in lines if not one.same_winner]
    if winners:
        return f"{where}, another solver is the first without {', '.join(winners)}."
    orders = [one.scene for one in lines if not one.same_order]
    rest = f"; the order of the first three changes without {', '.join(orders)}" if orders else ", and so do the first three"
    return f"{where}, the winner stays the same whichever scene is left out{rest}."
