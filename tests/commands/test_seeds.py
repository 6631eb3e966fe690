"""The table of hard families on the page of performance."""

import pytest

from frictionbench.commands.seeds import FAMILIES, Family, section
from frictionbench.problems.instances import make_instance


def _cells(family: Family) -> list[str]:
    return [cell.strip() for cell in section((family,)).splitlines()[-1].split("|")[1:-1]]


def test_only_verified_answers_count_as_solved() -> None:
    def make(seed):
        return make_instance("random_bodies", seed=seed, contacts=10 + seed)

    title, contacts, solved, worst, *_ = _cells(Family("bodies", make, 3))
    assert (title, contacts, solved, worst) == ("bodies", "10–12", "3 of 3", "")
    _, _, solved, worst, *_ = _cells(Family("bodies", make, 3, "relaxation_ip"))
    assert solved == "0 of 3"
    assert float(worst) > 1e-3  # contacts slide, which the relaxation answers with another motion


@pytest.mark.parametrize("family", FAMILIES, ids=[family.title for family in FAMILIES])
def test_instances_differ(family) -> None:
    if "4000" not in family.title and "levels" not in family.title:
        assert len({family.make(k).hash for k in range(3)}) == 3
