"""How many problems each member of `hybrid` brings, by the contacts' dimension and the first member.

Made by `python -m frictionbench.commands.shares`, which says how.
"""

BROUGHT: dict[tuple[int, str], dict[str, int]] = {
    (2, "lemke"): {
        "lemke": 265,
        "interior_point": 0,
        "path_search": 0,
        "staggered": 0,
        "anitescu_hart": 0,
        "fischer_newton": 0,
    },
    (2, "interior_point"): {
        "interior_point": 59,
        "lemke": 14,
        "path_search": 0,
        "staggered": 0,
        "anitescu_hart": 0,
        "fischer_newton": 0,
    },
    (3, "nsgs"): {
        "nsgs": 1,
        "interior_point": 25,
        "proximal_newton": 0,
        "nncg": 0,
        "apgd_coulomb": 0,
        "staggered": 0,
        "admm_coulomb": 0,
        "anitescu_hart": 0,
    },
    (3, "interior_point"): {
        "interior_point": 85,
        "nsgs": 1,
        "proximal_newton": 0,
        "nncg": 0,
        "apgd_coulomb": 0,
        "staggered": 0,
        "admm_coulomb": 0,
        "anitescu_hart": 0,
    },
}
