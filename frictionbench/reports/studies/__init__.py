"""The studies in words and figures, one file a study, in the order in which they are told."""

from collections.abc import Callable

from frictionbench.reports.studies import (
    compliance,
    cone,
    convexity,
    coordinates,
    dissipation,
    events,
    inclusion,
    interior,
    neighbours,
    orders,
    rankings,
    relaxation,
    warm,
)
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.results.studies import StudyTables

ACCOUNTS: dict[str, Callable[[StudyTables], Account]] = {
    "convexity": convexity.account,
    "relaxation": relaxation.account,
    "interior": interior.account,
    "dissipation": dissipation.account,
    "inclusion": inclusion.account,
    "cone": cone.account,
    "orders": orders.account,
    "events": events.account,
    "coordinates": coordinates.account,
    "compliance": compliance.account,
    "neighbours": neighbours.account,
    "warm": warm.account,
    "rankings": rankings.account,
}

__all__ = ["ACCOUNTS", "Account", "Figure"]
