"""The suites: named plans."""

from dataclasses import replace

from frictionbench.harness.plans import families
from frictionbench.harness.plans.atlas import ATLAS
from frictionbench.harness.plans.batches import batch
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
        expects="four minutes",
    )


def seeds() -> Plan:
    """The seven examples, the rod and the jam, with every solver of ours and every applicable time-stepping scheme."""
    scenes = (*(Source(name, pick=4) for name in EXAMPLES), Source("painleve_rod", pick=4))
    jam = Source("jam", {"sideways": 0.1}, pick=4)  # against a wall that it hits: else no impulse is an answer
    solvers = (*EXACT, *RELAXED, *OTHERS)
    return Plan(
        suite="seeds",
        sources=(*scenes, jam),
        solvers=solvers,
        tolerances=LADDER,
        simulations=tuple(replace(source, pick=0) for source in (*scenes, jam)),
        simulation_solvers=solvers,
        schemes=tuple(sorted(name for name, scheme in SCHEMES.items() if not scheme.events)),
        time_limit=2.0,
        simulation_limit=20.0,
        expects="nine minutes",
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
        expects="two minutes",
    )


def scaling() -> Plan:
    """Time against size: piles and chains of up to two thousand contacts, in the plane and in space, that are held by friction,
    on a slope or at rest, and that slide or are hit."""
    steep, hit, spun = families.STEEP, families.HIT, {"push": 0.1, "twist": 1.0, "smooth": 0.2, "fall": 1.0}
    grids: dict[str, tuple[str, tuple[int, ...], tuple[dict[str, float], ...]]] = {
        "stack": ("blocks", (1, 5, 20, 100, 500, 1000), (steep, {"push": 0.0, "shear": 0.01, "smooth": 0.1})),
        "pyramid": ("rows", (2, 4, 9, 22, 31), (steep, hit)),
        "wall": ("rows", (2, 4, 10, 40), (steep, hit)),
        "disc_pile": ("rows", (2, 5, 12, 30), ({}, {"friction": 0.1})),
        "chain": ("links", (2, 10, 50, 250), ({"ripple": 1.0}, {"fall": 1.0, "mass_ratio": 100.0})),
        "cubes": ("boxes", (1, 5, 25, 125), (steep, spun)),
        "sphere_pyramid": ("levels", (2, 3, 5, 8), ({"friction": 0.7}, {"friction": 0.2, "noise": 0.3})),
        "rod_chain": ("links", (2, 10, 50, 250), ({"pull": 0.02, "whirl": 0.02}, {"fall": 1.0})),
        "random_bodies": ("contacts", (4, 20, 100, 500), ({}, {"mass_ratio": 1e4})),
    }
    sources = [
        Source(name, {size: n, **settings})
        for name, (size, numbers, both) in grids.items()
        for n in numbers
        for settings in both
    ]
    return Plan(
        suite="scaling",
        sources=tuple(sources),
        solvers=(*EXACT, "apgd_coulomb", RELAXED[0]),
        spatial_solvers=SPATIAL,
        tolerances=(1e-4, 1e-8),
        time_limit=10.0,
        expects="twenty minutes",
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
        expects="a quarter of an hour",
    )


SUITES = {
    "smoke": smoke,
    "standard": standard,
    "seeds": seeds,
    "replay": replay,
    "scaling": scaling,
    "hard": hard,
    "batch": batch,
    "maps": maps,
    "recorded": recorded,
    "spatial": spatial,
    "abh2018": abh2018,
    "peers": peers,
}
