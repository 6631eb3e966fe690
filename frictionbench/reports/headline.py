"""The first sentences of the report: which solver is the fastest in the plane and in space, from bodies and from the method's
own form."""

from frictionbench.reports.choice import Choice, Kind
from frictionbench.reports.drawing.text import ahead, count, percent, power, seconds
from frictionbench.results.rank_by import RankBy


def headline(ranked: dict[RankBy, list[Kind]], overall: list[str], target: float) -> list[str]:
    """A sentence for each class of all problems of a dimension. ranked: the choices by each ranking; target: the finest."""
    found = {by: {kind.name: kind for kind in kinds} for by, kinds in ranked.items()}
    return [
        _sentence({by: kinds[name] for by, kinds in found.items()}, target)
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


def _sentence(kinds: dict[RankBy, Kind], target: float) -> str:
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
    told = f"with a mean of {seconds(best.mean)}{form}, {best.reached} of {choice.problems} solved"
    return told + (f", {ahead(choice.lead, choice.places[1].label)}" if choice.lead else "")
