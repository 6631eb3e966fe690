"""Who enters the suites, and at which tolerances."""

EXACT = ("hybrid", "lemke", "path_search", "interior_point", "nsgs")
RELAXED = ("ccp[backend=clarabel]", "ccp[backend=osqp]", "ccp[backend=proxqp]", "ccp_cone")
OTHERS = (
    *("fischer_newton", "minmap_newton", "dantzig", "murty"),
    *("staggered", "nncg", "anitescu_hart", "apgd_coulomb", "admm_coulomb", "apgd", "admm"),
)
LADDER = (1e-4, 1e-6, 1e-8)
