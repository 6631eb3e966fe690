"""The groups of solvers that suites compare, and their tolerances."""

# Methods for the exact law that every suite compares; one of each kind for the relaxation; further methods of both.
EXACT = ("hybrid", "lemke", "path_search", "interior_point", "nsgs")
RELAXED = ("ccp[backend=clarabel]", "ccp[backend=osqp]", "ccp[backend=proxqp]", "ccp_cone")
OTHERS = (
    *("fischer_newton", "minmap_newton", "dantzig", "murty"),
    *("staggered", "nncg", "anitescu_hart", "apgd_coulomb", "admm_coulomb", "apgd", "admm"),
)
LADDER = (1e-4, 1e-6, 1e-8)  # tolerances, from what simulations need to what exact methods reach
