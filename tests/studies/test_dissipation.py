"""Every solution dissipates most for its own normal impulses, at reduced size."""

from tests.helpers.studies import reduced, told


def test_the_principle_rejects_no_solution() -> None:
    size = {"draws": 12, "angles": (1.1,)}
    found = reduced("dissipation", solutions=size, returned=size | {"solvers": ("lemke", "nsgs")})
    solutions, returned = found["solutions"], found["returned"]
    assert solutions["number"].nunique() >= 2
    assert solutions["of"].min() >= 2
    assert (solutions["energy"] - solutions["least"]).abs().max() < 1e-6
    assert solutions["residual"].max() < 1e-7
    assert returned["rank"].dropna().isin([1, 2, 3]).all()
    assert told(found).answer.startswith("No. Every one of the solutions")
