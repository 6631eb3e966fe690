"""Reliability at the tightest tolerance of a run: which solvers are exact, which claim wrong solutions, and which crash.

An answer to another law, or with a polygon for the cone, solves its own model if the residual of that model is within the
tolerance; its error is its residual by Coulomb's law.
"""

from collections.abc import Callable
from typing import NamedTuple

from frictionbench.reports.accuracy import OVERALL
from frictionbench.reports.drawing.text import power, residual
from frictionbench.reports.run import Run
from frictionbench.reports.tables import model_errors
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
    errors = model_errors(run.tightest)
    inexact = [one for one in complete if one.exact < one.problems]
    claims: dict[str, tuple[list[Reliability], Callable[[Reliability], str] | None]] = {
        f"Every problem solved to {tol}": ([one for one in complete if one.exact == one.problems], None),
        f"Every problem solved to {tol} with a polygon for the cone in space, median error by Coulomb's law in brackets": (
            [one for one in inexact if one.model == "lcp"],
            lambda one: residual(errors.get(one.label, float("nan"))),
        ),
        "Wrong claims, with a residual above ten times the tolerance": (
            [one for one in found if one.wrong],
            lambda one: f"{one.wrong} of {one.problems}",
        ),
        "Crashed": ([one for one in found if one.crashed], lambda one: f"{one.crashed} of {one.problems}"),
        f"Every problem solved to {tol} for another law, the convex relaxation or soft contact, median error in brackets": (
            [one for one in inexact if one.model != "lcp"],
            lambda one: residual(errors.get(one.label, float("nan"))),
        ),
    }
    ran = run.tightest.groupby("label")["dimension"].agg(set)
    several = run.ranked["dimension"].nunique() > 1
    only = {label: f" ({OVERALL[min(found)]})" if several and len(found) == 1 else "" for label, found in ran.items()}
    return [
        (what, ", ".join(f"{one.label} ({count(one)})" if count else one.label + only[one.label] for one in solvers))
        for what, (solvers, count) in claims.items()
        if solvers
    ]
