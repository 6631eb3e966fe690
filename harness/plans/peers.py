"""The suite that puts every outside solver beside our own."""

from harness.plans.plan import Plan, Source
from solvers import available

OURS = ("hybrid", "lemke", "path_search", "interior_point", "nsgs", "nncg", "apgd_coulomb", "relaxation_ip", "apgd")


def peers() -> Plan:
    """Our solvers beside those a user would pick instead, in the plane and in space, in under fifteen minutes on two cores."""
    still = (
        *(Source("stack", {"blocks": n, "friction": 0.2, "push": 1.0}) for n in (1, 5, 25)),
        *(Source("pyramid", {"rows": rows, "friction": 0.5, "push": 1.0}) for rows in (3, 7)),
        Source("stack", {"blocks": 5, "mass_ratio": 1e4, "push": 1.0}),
        *(Source("random", {"seed": seed, "contacts": n}) for seed, n in ((0, 5), (1, 20))),
    )
    replayed = (Source("three_blocks", {}, pick=2), Source("several_blocks", {}, pick=2))
    spatial = (
        *(Source("cubes", {"boxes": n, "friction": 0.2, "push": 1.0}) for n in (1, 5, 15)),
        *(Source("random_bodies", {"seed": seed, "contacts": n}) for seed, n in ((0, 4), (1, 20), (2, 60))),
    )
    return Plan(
        suite="peers",
        sources=(*still, *replayed, *spatial),
        solvers=(*OURS, *(spec for _, info in sorted(available().items()) if info.needs for spec in info.specs)),
        tolerances=(1e-4, 1e-8),
        time_limit=1.0,
    )
