"""The plan for a suite's name and the command line's choices, and the scenes and instances that it names."""

from dataclasses import replace
from typing import Any

from frictionbench.harness.plans.config import RunOptions
from frictionbench.harness.plans.plan import BatchSource, Plan, Plugin, Source
from frictionbench.harness.plans.recorded import every, with_data
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import instances, near, require_known
from frictionbench.problems.check import require
from frictionbench.problems.spec import parse
from frictionbench.results.conventions import DRAWN
from frictionbench.results.maps import Map
from frictionbench.solvers import find

COUNT = 100  # problems of a batch that is named on the command line


def chosen(wanted: RunOptions, variants: tuple[str, ...], plugins: tuple[Plugin, ...]) -> Plan:
    """The plan of these options of `run`, with the variants and plug-ins that `solver` names. Errors: as of choose."""
    scenes, data = wanted.scene or [], tuple(wanted.data or ())
    suite, every_one = wanted.suite or "standard", bool(wanted.all_solvers)
    plan = choose(suite, scenes, variants, wanted.tol, wanted.time_limit, plugins, data, every_one)
    return replace(plan, options=wanted._replace(out=None).given())


def choose(
    suite: str,
    scene_specs: list[str],
    variants: tuple[str, ...],
    tol: str | None,
    time_limit: float | None,
    plugins: tuple[Plugin, ...] = (),
    data: tuple[str, ...] = (),
    all_solvers: bool = False,
) -> Plan:
    """The suite's plan with what is given in place of its own scenes, solvers and settings.

    all_solvers: whether every installed solver runs, by the dimension of the problem.

    Errors: InputError naming the field.
    """
    if suite not in SUITES:
        raise InputError(f"suite: unknown suite {suite!r}{near(suite, SUITES)}; known are {', '.join(SUITES)}")
    if data and scene_specs:
        raise InputError("data: names the problems to run, and so does --scene; give one of the two")
    if all_solvers and variants:
        raise InputError("all-solvers: runs every solver, and --solver names some; give one of the two")
    plan = with_data(SUITES[suite](), data)
    if scene_specs and plan.batches:
        plan = replace(plan, batches=tuple(each for spec in scene_specs for each in _batches(plan, spec)), expects="")
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
    if all_solvers:
        plan = replace(plan, solvers=every(2), spatial_solvers=every(3), simulation_solvers=every(2), expects="")
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


def _batches(plan: Plan, spec: str) -> tuple[BatchSource, ...]:
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
