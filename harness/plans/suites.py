"""The suites: named plans."""

from frictionbench.harness.plans import families
from frictionbench.harness.plans.atlas import ATLAS
from frictionbench.harness.plans.hard import hard
from frictionbench.harness.plans.lineups import EXACT, LADDER, OTHERS, RELAXED, SPATIAL
from frictionbench.harness.plans.peers import peers
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.plans.recorded import abh2018, recorded, spatial
from frictionbench.problems.schemes import SCHEMES
from frictionbench.results.conventions import COLD, KEEP_ANSWER, KEEP_VELOCITY, RELAX, SHUFFLED, WARM

MAPPED = (
    *EXACT,
    *(name for name in OTHERS if name not in ("apgd", "admm")),
)  # of the exact law; these two solve the relaxation
MAPPED_RELAXED = ("relaxation_ip", "apgd", "admm", *RELAXED[:3])
FAILING = (  # simulations in which some methods fail to solve steps
    Source("stack", {"blocks": 5, "mass_ratio": 1e3, "push": 1.0}, steps=60),
    Source("three_blocks", {}, steps=200),
    Source("multiple_collisions", {}, steps=200),
)
STEPS = (  # motions whose steps are problems: as many of each as a family of one step has
    Source("long_bar", {"friction": 0.2}, pick=2),
    Source("two_blocks", {"friction": 0.1}, pick=2),
    Source("three_blocks", {}, pick=2),
    Source("multiple_collisions", {}, pick=2),
    Source("several_blocks", {}, pick=2),
    Source("slider_crank", {}, pick=2, steps=200),
)
EXAMPLES = tuple(f"example_{i}" for i in range(1, 8))


def smoke() -> Plan:
    """A short check of everything, in under a minute: a few small problems, planar and spatial, and a short simulation."""
    return Plan(
        suite="smoke",
        sources=(
            Source("long_bar", {"friction": 0.2}, pick=2, steps=60),
            Source("two_blocks", {"friction": 0.1}, pick=2, steps=100),
            Source("painleve_rod", {}),
            Source("stack", {"blocks": 5}),
            Source("pyramid", {"rows": 3, "push": 0.0, "slope": 0.3}),
            Source("house_of_cards", {"storeys": 2, "friction": 0.12}),
            Source("cubes", {"boxes": 2, "push": 0.1, "twist": 1.0, "fall": 1.0}),
            Source("random_bodies", {"contacts": 20}),
        ),
        solvers=(*EXACT, *RELAXED),
        spatial_solvers=SPATIAL,
        tolerances=(1e-4, 1e-8),
        simulations=(Source("two_blocks", {"friction": 0.1}, steps=100),),
        simulation_solvers=(*EXACT, "ccp[backend=clarabel]"),
        time_limit=2.0,
        simulation_limit=20.0,
        expects="half a minute",
    )


def standard() -> Plan:
    """A first comparison, in the plane and in space: the main solvers on sticking, sliding and colliding contacts of all sizes,
    in under five minutes."""
    return Plan(
        suite="standard",
        sources=(*STEPS, *families.sources(*families.PLANE, *families.SPACE)),
        solvers=(*EXACT, *RELAXED),
        spatial_solvers=SPATIAL,
        tolerances=LADDER,
        simulations=STEPS,
        simulation_solvers=(*EXACT, *RELAXED),
        time_limit=2.0,
        simulation_limit=60.0,
        expects="three minutes",
    )


def seeds() -> Plan:
    """The seven examples, the rod and the jam, with every solver and every applicable scheme: about a quarter of an hour."""
    scenes = (*EXAMPLES, "painleve_rod", "jam")
    solvers = (*EXACT, *RELAXED, *OTHERS)
    return Plan(
        suite="seeds",
        sources=tuple(Source(name, pick=4) for name in scenes),
        solvers=solvers,
        tolerances=LADDER,
        simulations=tuple(Source(name) for name in scenes),
        simulation_solvers=solvers,
        schemes=tuple(sorted(SCHEMES)),
        time_limit=2.0,
        simulation_limit=20.0,
    )


def replay() -> Plan:
    """Recorded motions, with each problem solved from zero, from the previous answer, and from the answer of another step."""
    return Plan(
        suite="replay",
        sources=tuple(Source(name, pick=20, steps=150) for name in EXAMPLES),
        solvers=(*EXACT, *OTHERS),
        tolerances=(1e-6, 1e-8),
        starts=(COLD, WARM, SHUFFLED),
        time_limit=2.0,
    )


def scaling() -> Plan:
    """Time against size: stacks, pyramids and walls of 1 to 1000 boxes, three friction coefficients, mass ratios up to 1e6."""
    sizes = {
        "stack": [{"blocks": n} for n in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)],
        "pyramid": [{"rows": n} for n in (4, 9, 13, 31, 44)],
        "wall": [{"rows": n, "columns": n} for n in (3, 7, 10, 22, 32)],
    }
    pushed = [
        Source(name, {**size, "friction": mu, "push": 1.0})
        for name, grid in sizes.items()
        for size in grid
        for mu in (0.05, 0.2, 0.8)
    ]
    heavy = [Source("stack", {"blocks": n, "mass_ratio": ratio}) for n in (10, 100) for ratio in (1e2, 1e4, 1e6)]
    return Plan(
        suite="scaling",
        sources=(*pushed, *heavy),
        solvers=(*EXACT, "apgd_coulomb", *RELAXED[:3]),
        tolerances=(1e-4, 1e-8),
        time_limit=10.0,
    )


def maps() -> Plan:
    """Failure maps: for which parameters each method fails, in under twenty minutes on two cores."""
    return Plan(
        suite="maps",
        sources=(),
        solvers=(*MAPPED, *MAPPED_RELAXED),
        tolerances=(1e-6,),
        simulations=FAILING,
        simulation_solvers=(*MAPPED, *MAPPED_RELAXED),
        after_failure=(KEEP_ANSWER, KEEP_VELOCITY, RELAX),
        maps=ATLAS,
        simulation_tol=1e-6,
        time_limit=1.0,
        simulation_limit=10.0,
    )


SUITES = {
    "smoke": smoke,
    "standard": standard,
    "seeds": seeds,
    "replay": replay,
    "scaling": scaling,
    "hard": hard,
    "maps": maps,
    "recorded": recorded,
    "spatial": spatial,
    "abh2018": abh2018,
    "peers": peers,
}
