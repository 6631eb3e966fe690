"""The plan for a suite's name and the command line's choices."""

from dataclasses import replace

from frictionbench.harness.plans.batches import chosen_batches
from frictionbench.harness.plans.named import require_known
from frictionbench.harness.plans.plan import Plan, Plugin, Source
from frictionbench.harness.plans.recorded import with_data
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems import InputError
from frictionbench.problems.instances import instances
from frictionbench.problems.names import near
from frictionbench.problems.spec import parse
from frictionbench.results.maps import Map
from frictionbench.solvers import find


def choose(
    suite: str,
    scene_specs: list[str],
    variants: tuple[str, ...],
    tol: str | None,
    time_limit: float | None,
    plugins: tuple[Plugin, ...] = (),
    data: tuple[str, ...] = (),
) -> Plan:
    """The suite's plan with what is given in place of its own scenes, solvers and settings.

    Errors: InputError naming the field.
    """
    if suite not in SUITES:
        raise InputError(f"suite: unknown suite {suite!r}{near(suite, SUITES)}; known are {', '.join(SUITES)}")
    if data and scene_specs:
        raise InputError("data: names the problems to run, and so does --scene; give one of the two")
    plan = with_data(SUITES[suite](), list(data))
    if scene_specs and plan.batches:
        plan = replace(plan, batches=tuple(each for spec in scene_specs for each in chosen_batches(plan, spec)), expects="")
    elif scene_specs:
        chosen = [_chosen(plan, spec) for spec in scene_specs]
        plan = replace(
            plan,
            sources=tuple(s for met, _, _ in chosen for s in met),
            simulations=tuple(s for _, simulated, _ in chosen for s in simulated),
            maps=tuple(spec for _, _, mapped in chosen for spec in mapped),
            expects="",
        )
    if variants:
        plan = replace(plan, solvers=variants, spatial_solvers=(), simulation_solvers=variants, plugins=plugins, expects="")
    if tol is not None:
        plan = replace(plan, tolerances=tolerances(tol))
    if time_limit is not None:
        plan = replace(plan, time_limit=time_limit)
    for variant in plan.variants:
        if not plan.owner(variant):
            find(variant)
    return plan


def _chosen(plan: Plan, spec: str) -> tuple[list[Source], list[Source], list[Map]]:
    """Sources, simulations and maps: those of the suite with this name, or new ones where the spec has settings or the suite
    has none of this name."""
    name, settings = parse("scene", spec)
    own = [source for source in plan.sources if source.scene == name]
    mapped = [spec for spec in plan.maps if name in (spec.scene, spec.name)]
    if (own or mapped) and not settings:
        return own, [simulation for simulation in plan.simulations if simulation.scene == name], mapped
    require_known(name, settings)
    if name in instances():
        return [Source(name, settings)], [], []
    return [Source(name, settings, pick=6)], [Source(name, settings)], []


def tolerances(text: str) -> tuple[float, ...]:
    try:
        return tuple(dict.fromkeys(float(part) for part in text.split(",")))
    except ValueError:
        raise InputError(f"tol: cannot read {text!r}; write numbers like 1e-4,1e-8") from None
