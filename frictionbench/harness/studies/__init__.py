"""Studies: open questions of the field, each answered by tables; one file a study, here in the order in which they are told."""

from frictionbench.harness.studies import (
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
from frictionbench.harness.studies.study import Study, Table

_MODULES = (
    *(convexity, relaxation, interior, dissipation, inclusion, cone),
    *(orders, events, coordinates, compliance, neighbours, warm),
    rankings,
)
STUDIES: dict[str, Study] = {module.STUDY.name: module.STUDY for module in _MODULES}

__all__ = ["STUDIES", "Study", "Table"]
