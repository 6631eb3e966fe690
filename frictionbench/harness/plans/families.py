"""The problems of a first comparison, by family and size; the answer of each depends on friction.

A family is a scene or an instance. It has two problems in each band of sizes that it reaches (1, 2 to 10, 11 to 100 and more
contacts), so that all families count the same. Where possible, contacts stick, held by friction alone, in one problem, and
slide or collide in the other. Recorded motions (`recorded`) give as many steps each.
"""

from typing import Any

from frictionbench.harness.plans.plan import Source

Band = dict[str, tuple[dict[str, Any], dict[str, Any]]]  # two problems of each family
STEEP = {"push": 0.0, "slope": 0.3}  # a slope on which contacts stick by friction, and tall piles tip over
SHEARED = {"push": 0.0, "shear": 1.0}
HIT = {"push": 0.0, "shear": 0.2, "fall": 1.0}

ONE: Band = {
    "painleve_rod": ({"friction": 0.5, "lift": -1.0}, {"friction": 1.5}),
    "rocking_block": ({}, {"friction": 0.1, "spin": 1.0}),
    "bouncing_ball": ({"height": 0.0, "friction": 0.3, "spin": 10.0}, {"height": 0.0, "friction": 0.3, "speed": 0.005}),
}
SMALL: Band = {
    "two_corner_block": ({"fall": 1.0}, {"friction": 2.0, "fall": 1.0}),
    "incline": ({}, {"friction": 0.7}),
    "redundant_table": ({"legs": 4}, {"legs": 8, "speed": 0.03}),
    # The disc hits one wall, so that friction acts. If it only touched both walls, zero impulses would be a solution.
    "jam": ({"sideways": 0.1}, {"sideways": 0.1, "speed": 0.1}),
    "wedge": ({"friction": 0.2}, {"friction": 0.8, "speed": 10.0}),
    "stack": ({"blocks": 2, **STEEP}, {"blocks": 4, "smooth": 0.2}),
    "arch": ({"stones": 3}, {"stones": 3, "friction": 0.1}),
    "house_of_cards": ({"storeys": 1}, {"storeys": 1, "friction": 0.1}),
    "disc_pile": ({"rows": 2}, {"rows": 2, "friction": 0.1}),
    "chain": ({"links": 3, "ripple": 1.0}, {"links": 4, "pull": 0.03, "mass_ratio": 100.0}),
    "random": ({"contacts": 3}, {"contacts": 8, "seed": 1}),
}
MEDIUM: Band = {
    "stack": ({"blocks": 20, **STEEP}, {"blocks": 20, "push": 0.0, "shear": 0.01, "smooth": 0.1}),
    "pyramid": ({"rows": 4, **STEEP}, {"rows": 4, **HIT}),
    "wall": ({"rows": 3, "columns": 3, "friction": 0.1}, {"rows": 3, "columns": 3, **HIT}),
    "arch": ({"stones": 25}, {"stones": 15, "friction": 0.1}),
    "house_of_cards": ({"storeys": 2, "friction": 0.12}, {"storeys": 3, "push": 0.5}),
    "disc_pile": ({"rows": 5, "mass_ratio": 100.0}, {"rows": 5, "friction": 0.1}),
    "chain": ({"links": 20, "fall": 1.0}, {"links": 20, "ripple": 1.0}),
    "random": ({"contacts": 30}, {"contacts": 40, "seed": 1}),
}
LARGE: Band = {
    "stack": ({"blocks": 100, **STEEP}, {"blocks": 60, "push": 0.0, "shear": 0.01, "smooth": 0.1}),
    "pyramid": ({"rows": 9, "friction": 0.05, **SHEARED}, {"rows": 9, **HIT}),
    "wall": ({"rows": 6, "columns": 6, **STEEP}, {"rows": 6, "columns": 6, "friction": 0.05}),
    "arch": ({"stones": 61}, {"stones": 61, "friction": 0.05}),
    "house_of_cards": ({"storeys": 5}, {"storeys": 6, "friction": 0.12}),
    "disc_pile": ({"rows": 10}, {"rows": 10, "friction": 0.1}),
    "chain": ({"links": 80, "fall": 1.0}, {"links": 80, "ripple": 0.5}),
    "random": ({"contacts": 150}, {"contacts": 200, "seed": 1}),
}
SPACE_ONE: Band = {
    "sphere_pyramid": ({"levels": 1, "noise": 1.0}, {"levels": 1, "noise": 0.1, "seed": 1}),
    "random_bodies": ({"contacts": 1}, {"contacts": 1, "seed": 2, "friction": 10.0}),
}
SPACE_SMALL: Band = {
    "cubes": ({"boxes": 2, **STEEP}, {"boxes": 2, "friction": 0.2, "push": 0.5, "twist": 2.0, "fall": 1.0}),
    "random_bodies": ({"contacts": 5}, {"contacts": 8, "seed": 1}),
    "rod_chain": ({"links": 4}, {"links": 4, "pull": 0.01, "whirl": 0.0}),
}
SPACE_MEDIUM: Band = {
    "cubes": ({"boxes": 10, **STEEP}, {"boxes": 10, "push": 0.1, "twist": 1.0, "smooth": 0.2, "fall": 1.0}),
    "sphere_pyramid": ({"levels": 2, "friction": 0.1}, {"levels": 3, "noise": 0.3}),
    "packed_spheres": ({"spheres": 15, "noise": 1.0}, {"spheres": 25, "fraction": 0.5, "friction": 0.2}),
    "random_bodies": ({"contacts": 40}, {"contacts": 40, "friction": 10.0, "mass_ratio": 1e3}),
    "rod_chain": ({"links": 20, "fall": 1.0}, {"links": 20, "pull": 0.03, "whirl": 0.05, "mass_ratio": 100.0}),
}
SPACE_LARGE: Band = {
    "cubes": (
        {"boxes": 40, "friction": 0.05, "push": 0.3, "twist": 1.0},
        {"boxes": 40, "push": 0.1, "twist": 1.0, "smooth": 0.2, "fall": 1.0},
    ),
    "sphere_pyramid": ({"levels": 5, "friction": 0.7}, {"levels": 5, "friction": 0.2, "noise": 0.3}),
    "packed_spheres": ({"spheres": 60}, {"spheres": 100, "fraction": 0.5, "friction": 0.2}),
    "random_bodies": ({"contacts": 150}, {"contacts": 200, "seed": 1, "mass_ratio": 1e3}),
    "rod_chain": ({"links": 60, "fall": 1.0}, {"links": 60, "pull": 0.02, "whirl": 0.02}),
}
PLANE = (ONE, SMALL, MEDIUM, LARGE)
SPACE = (SPACE_ONE, SPACE_SMALL, SPACE_MEDIUM, SPACE_LARGE)


def sources(*bands: Band) -> tuple[Source, ...]:
    """Return the problems of these bands."""
    return tuple(Source(name, settings) for band in bands for name, both in band.items() for settings in both)


def halves(*bands: Band) -> tuple[Source, ...]:
    """Return one problem of each family in these bands, alternating between the first and the second."""
    return tuple(Source(name, both[i % 2]) for band in bands for i, (name, both) in enumerate(band.items()))
