"""The suite that compares every outside solver with our own."""

from frictionbench.harness.plans import families
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.solvers import available, find

# The fastest of our methods for each kind of problem, and simple ones as a reference.
OURS = ("hybrid", "lemke", "path_search", "interior_point", "nsgs", "nncg", "apgd_coulomb", "relaxation_ip", "apgd")


PLANE = (families.ONE, families.MEDIUM, families.LARGE)  # small ones of several contacts are many, and alike


def peers() -> Plan:
    """Our solvers compared with outside libraries, on planar and spatial problems."""
    stepped = (Source("three_blocks", {}, pick=1), Source("several_blocks", {}, pick=1))
    return Plan(
        suite="peers",
        sources=(*stepped, *families.halves(*PLANE, *families.SPACE)),
        solvers=(*OURS, *theirs(2)),
        spatial_solvers=(*OURS, "proximal_newton", *theirs(3)),
        tolerances=(1e-4, 1e-8),
        time_limit=1.0,
        expects="half an hour",
    )


def theirs(dimension: int) -> tuple[str, ...]:
    """All solvers of outside libraries, also of those that are not installed, that take problems of this dimension."""
    specs = [spec for _, info in sorted(available().items()) if info.needs for spec in info.specs]
    return tuple(spec for spec in specs if dimension in find(spec)[0].dimension)
