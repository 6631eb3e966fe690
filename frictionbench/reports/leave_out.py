"""Which scenes decide a ranking: the order of the solvers when each scene is left out in turn.

The order is that of reports.choice at the finest target, over all problems of the plane or of space, among the solvers that ran
on all of them.
"""

from collections.abc import Mapping
from typing import NamedTuple

import pandas as pd

from frictionbench.reports.balance import weights
from frictionbench.reports.choice import compared, kinds, too_few
from frictionbench.reports.run import Run
from frictionbench.results.conventions import RankBy


class LeftOut(NamedTuple):
    """A scene: its share of the weight, and whether without it the winner, and the order of the first three, are the same."""

    scene: str
    weight: float
    winner: str
    same_winner: bool
    same_order: bool


def left_out(run: Run) -> dict[str, list[LeftOut]]:
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


def sentences(by_ranking: Mapping[RankBy, Mapping[str, list[LeftOut]]]) -> list[str]:
    """Which scenes decide the rankings of each class, in words. by_ranking: left_out of the run ranked by each time."""
    told = [_sentence(name, lines, by) for by, found in by_ranking.items() for name, lines in found.items()]
    return [line for line in told if line]


def _sentence(name: str, lines: list[LeftOut], by: RankBy) -> str:
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
