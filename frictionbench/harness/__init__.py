"""Plans, runs, isolates, verifies and times.

The names below are what programs outside the package use; each is imported when it is first used.
"""

from typing import TYPE_CHECKING

from frictionbench.lazy import importer

if TYPE_CHECKING:
    from frictionbench.harness.cells.collect import stored_friction as stored_friction
    from frictionbench.harness.contract.examine import Found as Found, examine as examine
    from frictionbench.harness.machine import content as content
    from frictionbench.harness.plans import families as families, hard as hard, robots as robots
    from frictionbench.harness.plans.plan import Plan as Plan, Source as Source
    from frictionbench.harness.process import cores as cores, die_with_parent as die_with_parent
    from frictionbench.harness.progress import Progress as Progress
    from frictionbench.harness.run import run as run_plan

__all__ = ["run_plan"]  # the name that is another there
__getattr__ = importer(__name__, __file__)
