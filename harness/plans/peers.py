"""The suite that compares every outside solver with our own."""

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.solvers import available

# The fastest of our methods for each kind of problem, and simple ones as a reference.
OURS = ("hybrid", "lemke", "path_search", "interior_point", "nsgs", "nncg", "apgd_coulomb", "relaxation_ip", "apgd")


def peers() -> Plan:
    """Our solvers compared with outside libraries, on planar and spatial problems, in under fifteen minutes on two cores."""
    at_rest = (
        *(Source("stack", {"blocks": n, "friction": mu, "push": 1.0}) for n in (1, 5, 10, 25, 50) for mu in (0.05, 0.8)),
        *(Source("pyramid", {"rows": rows, "friction": 0.2, "push": 1.0}) for rows in (3, 5, 7)),
        *(Source("random", {"seed": seed, "contacts": n}) for seed, n in ((0, 5), (1, 20))),
    )
    large = (Source("stack", {"blocks": 75, "push": 1.0}), Source("pyramid", {"rows": 10, "push": 1.0}))
    heavy = tuple(Source("stack", {"blocks": n, "mass_ratio": 1e6, "push": 1.0}) for n in (5, 10))
    replayed = (Source("three_blocks", {}, pick=2), Source("several_blocks", {}, pick=2))
    spatial = (
        *(Source("cubes", {"boxes": n, "friction": 0.2, "push": 1.0}) for n in (1, 5, 15, 30)),
        *(Source("random_bodies", {"seed": seed, "contacts": n}) for seed, n in ((0, 4), (1, 20), (2, 60), (3, 120))),
        Source("cubes", {"boxes": 5, "mass_ratio": 1e6, "push": 1.0}),
        Source("packed_spheres", {"spheres": 20}),
    )
    return Plan(
        suite="peers",
        sources=(*at_rest, *large, *heavy, *replayed, *spatial),
        solvers=(*OURS, *(spec for _, info in sorted(available().items()) if info.needs for spec in info.specs)),
        tolerances=(1e-4, 1e-8),
        time_limit=1.0,
    )
