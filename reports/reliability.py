"""Reliability at the tightest tolerance of a run: which solvers are exact, which claim wrong solutions, and which crash.

An answer to a relaxation, or to an LCP with a polygonal cone, solves its own model if the residual of that model is within the
tolerance.
"""

from collections.abc import Callable
from typing import NamedTuple

from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import Run
from frictionbench.results.verdicts import Verdict, measured


class Reliability(NamedTuple):
    """How many of the problems that a solver ran on ended how. exact: residual of the exact problem within the tolerance; own:
    residual of the exact problem or of its own model within the tolerance; the others count verdicts."""

    label: str
    model: str
    problems: int
    exact: int
    own: int
    near_miss: int
    wrong: int
    timeout: int
    crashed: int


def reliabilities(run: Run) -> list[Reliability]:
    """One per label, the most often exact first."""
    rows = run.tightest[measured(run.tightest)]
    found = []
    for label, own in rows.groupby("label", sort=False):
        solved = own["residual"] <= own["tol"], own["own_solved"]
        ended = [
            int((own["verdict"] == verdict).sum())
            for verdict in (Verdict.NEAR_MISS, Verdict.WRONG, Verdict.TIMEOUT, Verdict.CRASHED)
        ]
        found.append(Reliability(str(label), own["model"].iloc[0], len(own), *(int(one.sum()) for one in solved), *ended))
    return sorted(found, key=lambda one: (-one.exact, -one.own))


def sentences(run: Run) -> list[tuple[str, str]]:
    """Statements, each with the solvers that it holds for, as text with counts; those that hold for none are left out."""
    found = reliabilities(run)
    if not found:
        return []
    tol = power(float(run.ranked["tol"].min()))
    complete = [one for one in found if one.own == one.problems]
    claims: dict[str, tuple[list[Reliability], Callable[[Reliability], int] | None]] = {
        f"Every problem solved to {tol}": ([one for one in complete if one.exact == one.problems], None),
        f"Every problem solved to {tol} with a polygonal cone in space": (
            [one for one in complete if one.exact < one.problems and one.model == "lcp"],
            None,
        ),
        "Wrong claims, with a residual above ten times the tolerance": (
            [one for one in found if one.wrong],
            lambda one: one.wrong,
        ),
        "Crashed": ([one for one in found if one.crashed], lambda one: one.crashed),
        f"Every problem solved to {tol} as a convex relaxation, whose friction law differs for sliding contacts": (
            [one for one in complete if one.exact < one.problems and one.model != "lcp"],
            None,
        ),
    }
    return [
        (what, ", ".join(f"{one.label} ({count(one)} of {one.problems})" if count else one.label for one in solvers))
        for what, (solvers, count) in claims.items()
        if solvers
    ]
