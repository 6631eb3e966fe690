"""Batches: many small problems of one scene and size, each with a push, a friction and a mass ratio of its own."""

from typing import Any

from frictionbench.harness.plans.named import require_known
from frictionbench.harness.plans.plan import BatchSource, Plan
from frictionbench.problems.check import require
from frictionbench.problems.spec import parse
from frictionbench.results.conventions import DRAWN

PLANE = {2: 500, 4: 300, 10: 150, 20: 60, 40: 20}  # by contacts, how many stacks of boxes: some hundredths of a second together
SPACE = {4: 100, 12: 30, 40: 10}  # stacks of cubes
COUNT = 100  # of a scene that is named on the command line
LOOPED = ("nsgs", "interior_point", "hybrid")
OUTSIDE = ("osqp", "daqp", "mujoco[method=newton,settings=tuned]")  # one by one: they take no batches of given problems


def batch() -> Plan:
    """Many small problems at once: problems a second at a verified residual, packed and one by one, cold and warm, on one core
    and on all."""
    stacks = [BatchSource("stack", {"blocks": contacts // 2}, count) for contacts, count in PLANE.items()]
    cubes = [BatchSource("cubes", {"boxes": contacts // 4}, count) for contacts, count in SPACE.items()]
    return Plan(
        suite="batch",
        sources=(),
        solvers=("lemke", "dantzig", "path_search", *LOOPED, "quantecon[settings=tuned]", *OUTSIDE),
        spatial_solvers=LOOPED,
        tolerances=(1e-8,),
        batches=(*stacks, *cubes),
        time_limit=60.0,
        expects="ten minutes",
    )


def chosen_batches(plan: Plan, spec: str) -> tuple[BatchSource, ...]:
    """The plan's batches of the scene with this name, or one of COUNT problems where the spec has settings.

    Errors: InputError naming the scene or the setting that is unknown, or where the scene has none of those that are drawn.
    """
    name, settings = parse("scene", spec)
    own = tuple(source for source in plan.batches if source.scene == name)
    if own and not settings:
        return own
    given: dict[str, Any] = dict.fromkeys(DRAWN, 1.0) | settings
    require_known(name, settings)
    try:
        require_known(name, given)
    except ValueError:
        require(
            False, "scene", f"{name} cannot be a batch: its problems differ by {', '.join(DRAWN)}, and it has not all of them"
        )
    return (BatchSource(name, settings, COUNT),)
