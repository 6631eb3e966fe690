"""The suites: named plans."""

from collections.abc import Iterable
from dataclasses import replace
from hashlib import sha256
from typing import Any

import numpy as np

from frictionbench.harness import machine
from frictionbench.harness.plans import families, robots as of_robots
from frictionbench.harness.plans.atlas import atlas
from frictionbench.harness.plans.hard import hard
from frictionbench.harness.plans.plan import BatchSource, Plan, Source
from frictionbench.harness.plans.recorded import LADDER, installed, recorded, spatial, theirs
from frictionbench.problems.catalogue import instances, scenes
from frictionbench.problems.schemes import SCHEMES
from frictionbench.results.conventions import COLD, SHUFFLED, WARM

# COULOMB: methods for Coulomb's law that every suite compares. RELAXATION: one of each kind for the relaxation. FURTHER: more
# methods for both. IN_SPACE: one of each kind in space, where the pivoting method has a polygonal cone.
COULOMB = ("hybrid", "lemke", "path_search", "interior_point", "nsgs")
RELAXATION = ("clarabel[settings=default]", "osqp", "proxsuite[matrices=sparse,settings=tuned]")
FURTHER = (
    *("fischer_newton", "minmap_newton", "dantzig", "murty"),
    *("staggered", "nncg", "anitescu_hart", "apgd_coulomb", "admm_coulomb", "apgd", "admm"),
)
IN_SPACE = ("hybrid", "interior_point", "nsgs", "proximal_newton", "apgd_coulomb", "lemke[facets=16]", RELAXATION[0])
# Outside solvers that solve the most in `peers` or of robots' steps, or are the fastest of their library, in double
# precision: for Coulomb's law in the plane and in space, and for the LCP in the plane, where it is equivalent.
OUTSIDE = (
    *("siconos[method=friction_3d_prox,settings=tuned]", "siconos[method=friction_3d_vi_eg]"),
    *("siconos[method=friction_3d_nsgs]", "siconos[method=friction_3d_nsgs,settings=newton]"),
    "pinocchio[method=admm,settings=tuned]",
)
OUTSIDE_LCP = ("path[settings=tuned]", "quantecon[settings=tuned]")
# The fastest of our methods for each kind of problem, and simple ones for comparison with outside libraries.
OURS = ("hybrid", "lemke", "path_search", "interior_point", "nsgs", "nncg", "apgd_coulomb", "relaxation_ip", "apgd")
# Batches of stacks of boxes and of cubes, contacts to number of problems: a batch takes some hundredths of a second.
STACKS = {2: 500, 4: 300, 10: 150, 20: 60, 40: 20}
CUBES = {4: 100, 12: 30, 40: 10}
BATCHED = ("nsgs", "interior_point", "hybrid")
ONE_BY_ONE = ("osqp", "daqp", "mujoco[method=newton,settings=tuned]")  # these accept no batches of given problems
SPREAD = 1.25  # largest factor by which drawn settings are changed
SETTING_DIGITS = 3  # significant digits of drawn settings, so that names of problems can be read
# Methods for Coulomb's law; apgd and admm solve the relaxation.
MAPPED = (*COULOMB, *(name for name in FURTHER if name not in ("apgd", "admm")))
MAPPED_RELAXED = ("relaxation_ip", "apgd", "admm", *RELAXATION)
FAILING = (  # simulations in which some methods fail to solve steps
    Source("stack", {"blocks": 5, "mass_ratio": 1e3, "push": 1.0}, steps=60),
    Source("three_blocks", {}, steps=200),
    Source("multiple_collisions", {}, steps=200),
)
STEPS = (  # motions whose steps are problems: as many from each as a family has in a band
    Source("long_bar", {"friction": 0.2}, pick=2),
    Source("two_blocks", {"friction": 0.1}, pick=2),
    Source("three_blocks", {}, pick=2),
    Source("multiple_collisions", {}, pick=2),
    Source("several_blocks", {}, pick=2),
    Source("slider_crank", {}, pick=2, steps=200),
)
EXAMPLES = tuple(f"example_{i}" for i in range(1, 8))


def smoke() -> Plan:
    """A short check of everything: a few small problems, planar and spatial, and a short simulation."""
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
        solvers=(*COULOMB, *RELAXATION),
        spatial_solvers=IN_SPACE,
        tolerances=(1e-4, 1e-8),
        simulations=(Source("two_blocks", {"friction": 0.1}, steps=100),),
        simulation_solvers=(*COULOMB, RELAXATION[0]),
        time_limit=2.0,
        simulation_limit=20.0,
        expects="half a minute",
    )


def standard() -> Plan:
    """A first comparison in the plane and in space, on sticking, sliding and colliding contacts of all sizes: the main solvers,
    and the installed outside solvers for Coulomb's law."""
    outside, planar = installed(*OUTSIDE), installed(*OUTSIDE_LCP)
    return Plan(
        suite="standard",
        sources=(*STEPS, *families.sources(*families.PLANE, *families.SPACE), *of_robots.one_of_each()),
        solvers=(*COULOMB, *RELAXATION, *outside, *planar),
        spatial_solvers=(*IN_SPACE, *outside),
        tolerances=LADDER,
        simulations=STEPS,
        simulation_solvers=(*COULOMB, *RELAXATION),
        time_limit=2.0,
        expects="up to eight minutes" if outside or planar else "four minutes",
    )


def sealed() -> Plan:
    """The families of `standard` with settings drawn by a hash of this version's source, for which nobody can have tuned."""
    digest = machine.content(("problems", "solvers"))
    problems = drawn((*STEPS, *families.sources(*families.PLANE, *families.SPACE)), digest)
    return replace(standard(), suite="sealed", sources=problems, simulations=())


def drawn(sources: Iterable[Source], digest: str) -> tuple[Source, ...]:
    """Return these sources with settings that nobody has chosen, drawn by a digest as seed. That of the source of all problems
    and solvers changes with any line of it, so that no method can have been tuned on the settings.

    Counts and numbers that a family is given, and its friction, are multiplied by factors between 1/SPREAD and SPREAD, uniform
    in their logarithms, so that the pattern of sticking and sliding is mostly preserved. A seed is drawn anew. This does not
    prevent changing a comment until a draw suits, but each draw can be reproduced from the commit of its version.
    """
    return tuple(replace(source, parameters=_drawn(source, f"{digest} {k}")) for k, source in enumerate(sources))


def _drawn(source: Source, name: str) -> dict[str, Any]:
    draw = np.random.default_rng(list(sha256(name.encode()).digest()))
    defaults = (scenes() | instances())[source.scene].parameters
    settings = {key: defaults[key] for key in ("seed", "friction") if defaults.get(key) is not None} | source.parameters
    factors = {key: SPREAD ** draw.uniform(-1, 1) for key in sorted(settings)}
    drawn = {key: _scaled(value, factors[key]) for key, value in settings.items()}
    return drawn | ({"seed": int(draw.integers(10**6))} if "seed" in drawn else {})


def _scaled(value: float, factor: float) -> float:
    return max(1, round(value * factor)) if isinstance(value, int) else float(f"{value * factor:.{SETTING_DIGITS}g}")


def seeds() -> Plan:
    """The seven examples, the rod and the jam, with main and further solvers and every applicable time-stepping scheme."""
    steps = (*(Source(name, pick=4) for name in EXAMPLES), Source("painleve_rod", pick=4))
    jam = Source("jam", {"sideways": 0.1}, pick=4)  # the disc hits a wall: otherwise zero impulses would be a solution
    solvers = (*COULOMB, *RELAXATION, *FURTHER)
    return Plan(
        suite="seeds",
        sources=(*steps, jam),
        solvers=solvers,
        tolerances=LADDER,
        simulations=tuple(replace(source, pick=0) for source in (*steps, jam)),
        simulation_solvers=solvers,
        schemes=tuple(sorted(name for name, scheme in SCHEMES.items() if not scheme.events)),
        time_limit=2.0,
        simulation_limit=20.0,
        expects="nine minutes",
    )


def replay() -> Plan:
    """Recorded motions, with each problem started from zero, from the previous answer, and from the answer to another step."""
    return Plan(
        suite="replay",
        sources=tuple(Source(name, pick=20, steps=150) for name in EXAMPLES),
        solvers=(*COULOMB, *FURTHER),
        tolerances=(1e-6, 1e-8),
        starts=(COLD, WARM, SHUFFLED),
        time_limit=2.0,
        expects="two minutes",
    )


def scaling() -> Plan:
    """Time against size: piles and chains of up to two thousand contacts, in the plane and in space, held by friction on a
    slope or at rest, or sliding or hit."""
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
        solvers=(*COULOMB, "apgd_coulomb", RELAXATION[0]),
        spatial_solvers=IN_SPACE,
        tolerances=(1e-4, 1e-8),
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
        maps=atlas(),
        simulation_tol=1e-6,
        time_limit=1.0,
        simulation_limit=10.0,
        expects="a quarter of an hour",
    )


def batch() -> Plan:
    """Many small problems at once: problems per second at a verified residual, packed and one by one, cold and warm."""
    stacks = [BatchSource("stack", {"blocks": contacts // 2}, count) for contacts, count in STACKS.items()]
    cubes = [BatchSource("cubes", {"boxes": contacts // 4}, count) for contacts, count in CUBES.items()]
    return Plan(
        suite="batch",
        sources=(),
        solvers=("lemke", *BATCHED, "quantecon[settings=tuned]", *ONE_BY_ONE),
        spatial_solvers=BATCHED,
        tolerances=(1e-8,),
        batches=(*stacks, *cubes),
        time_limit=60.0,
        expects="ten minutes",
    )


def robots() -> Plan:
    """Steps of robots recorded from models of other packages, with limits and dry friction of joints, cold and warm."""
    return Plan(
        suite="robots",
        sources=of_robots.steps(),
        solvers=IN_SPACE,
        tolerances=LADDER,
        starts=(COLD, WARM),
        time_limit=2.0,
        expects="ten minutes",
    )


def peers() -> Plan:
    """Our solvers compared with outside libraries, installed or not, on planar and spatial problems."""
    stepped = (Source("three_blocks", {}, pick=1), Source("several_blocks", {}, pick=1))
    planar = (families.ONE, families.MEDIUM, families.LARGE)  # not SMALL, which has many families that are much alike
    return Plan(
        suite="peers",
        sources=(*stepped, *families.halves(*planar, *families.SPACE)),
        solvers=(*OURS, *theirs(2)),
        spatial_solvers=(*OURS, "proximal_newton", *theirs(3)),
        tolerances=(1e-4, 1e-8),
        time_limit=1.0,
        expects="half an hour",
    )


_ALL = (smoke, standard, sealed, seeds, replay, robots, scaling, hard, batch, maps, recorded, spatial, peers)
SUITES = {make.__name__: make for make in _ALL}
