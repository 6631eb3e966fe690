"""Who is exact, who claims falsely, and who dies, at the tightest tolerance of a run: a line an label, and all in sentences.

A relaxation's or a polygon's answers are exact as such where the residual of that model is within the tolerance.
"""

from collections.abc import Callable
from typing import NamedTuple

from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import Run
from frictionbench.results.verdicts import Verdict


class Reliability(NamedTuple):
    """Of the problems that an label met how many it ended how; own: exactly in its own model."""

    label: str
    model: str
    problems: int
    exact: int
    own: int
    missed: int
    wrong: int
    timeout: int
    crashed: int


def reliabilities(run: Run) -> list[Reliability]:
    """Those exact most often first."""
    rows = run.contested[(run.contested["tol"] == run.contested["tol"].min()) & (run.contested["verdict"] != Verdict.SKIPPED)]
    found = []
    for label, own in rows.groupby("label", sort=False):
        exact, model = own["residual"] <= own["tol"], own[["residual", "model_residual"]].min(axis=1) <= own["tol"]
        ended = [
            int((own["verdict"] == verdict).sum())
            for verdict in (Verdict.NEAR_MISS, Verdict.WRONG, Verdict.TIMEOUT, Verdict.CRASHED)
        ]
        found.append(Reliability(str(label), own["model"].iloc[0], len(own), int(exact.sum()), int(model.sum()), *ended))
    return sorted(found, key=lambda one: (-one.exact, -one.own))


def sentences(run: Run) -> list[tuple[str, str]]:
    """What is said of labels, and which they are, with counts; what holds of nobody is left out."""
    everybody = reliabilities(run)
    if not everybody:
        return []
    to = power(float(run.contested["tol"].min()))
    everywhere = [one for one in everybody if one.own == one.problems]
    claims: dict[str, tuple[list[Reliability], Callable[[Reliability], int] | None]] = {
        f"Exact to {to} on every problem taken": ([one for one in everywhere if one.exact == one.problems], None),
        f"To {to} as well, with a polygon for the cone in space": (
            [one for one in everywhere if one.exact < one.problems and one.model == "lcp"],
            None,
        ),
        "Claim answers that are off by more than ten times": ([one for one in everybody if one.wrong], lambda one: one.wrong),
        "Died": ([one for one in everybody if one.crashed], lambda one: one.crashed),
        f"To {to} as well, of a relaxation, another law where bodies slide": (
            [one for one in everywhere if one.exact < one.problems and one.model != "lcp"],
            None,
        ),
    }
    return [
        (what, ", ".join(_named(one, count(one) if count else None) for one in labels))
        for what, (labels, count) in claims.items()
        if labels
    ]


def _named(one: Reliability, count: int | None) -> str:
    return one.label if count is None else f"{one.label} ({count} of {one.problems})"
