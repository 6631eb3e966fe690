"""`frictionbench map`: the plan of one failure map."""

from frictionbench.harness.maps import axis
from frictionbench.harness.plans.choose import tolerances
from frictionbench.harness.plans.plan import Plan, Plugin
from frictionbench.harness.plans.suites import MAPPED
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import find_scene
from frictionbench.problems.schemes import require_scheme
from frictionbench.problems.spec import parse
from frictionbench.results.conventions import DEFAULT_SCHEME
from frictionbench.results.maps import Map

SOLVERS = (*MAPPED, "relaxation_ip")


def plan_map(
    scene_spec: str,
    x: str,
    y: str,
    variants: tuple[str, ...] = (),
    plugins: tuple[Plugin, ...] = (),
    tol: str = "1e-6",
    time_limit: float = 1.0,
    scheme: str = DEFAULT_SCHEME,
    steps: int = 0,
) -> Plan:
    """The plan of one map, of simulations where steps > 0. Errors: InputError naming the field; no scene is built."""
    name, settings = parse("scene", scene_spec)
    find_scene(name, settings)
    require_scheme(scheme)
    across, upwards = axis("x", x, name), axis("y", y, name)
    if across.parameter == upwards.parameter:
        raise InputError(f"y: {upwards.parameter} is already on the other axis; name another parameter")
    spec = Map(
        name=f"{name}_{across.parameter}_{upwards.parameter}",
        scene=name,
        x=across,
        y=upwards,
        parameters=settings,
        scheme=scheme,
        steps=steps,
        most=across.count * upwards.count,
        thresholds=() if steps else ("p", "P0", "pointed", "gaps"),
        title=scene_spec,
    )
    ladder = tolerances(tol)
    return Plan(
        suite="map",
        sources=(),
        solvers=variants or SOLVERS,
        tolerances=ladder,
        simulation_solvers=variants or SOLVERS,
        simulation_tol=min(ladder),
        maps=(spec,),
        time_limit=time_limit,
        plugins=plugins,
    )
