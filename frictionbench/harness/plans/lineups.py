"""The groups of solvers that suites compare, and their tolerances."""

from frictionbench.solvers import available, find

# Methods for the exact law that every suite compares; one of each kind for the relaxation; further methods of both. In space
# one of each kind, the pivoting one with a polygon for the cone.
EXACT = ("hybrid", "lemke", "path_search", "interior_point", "nsgs")
RELAXED = ("ccp[backend=clarabel]", "ccp[backend=osqp]", "ccp[backend=proxqp]", "ccp_cone")
OTHERS = (
    *("fischer_newton", "minmap_newton", "dantzig", "murty"),
    *("staggered", "nncg", "anitescu_hart", "apgd_coulomb", "admm_coulomb", "apgd", "admm"),
)
SPATIAL = ("hybrid", "interior_point", "nsgs", "proximal_newton", "apgd_coulomb", "lemke[facets=16]", "ccp_cone")
LADDER = (1e-4, 1e-6, 1e-8)  # tolerances, from what simulations need to what exact methods reach


def every(dimension: int) -> tuple[str, ...]:
    """All solvers that are installed and take problems of this dimension, ours before those of outside libraries."""
    specs = [
        spec for _, info in sorted(available().items(), key=lambda item: (bool(item[1].needs), item[0])) for spec in info.specs
    ]
    return tuple(spec for spec in specs if dimension in find(spec)[0].dimension and not find(spec)[0].missing)
