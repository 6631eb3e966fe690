"""The suite `sealed`: its problems follow from the source of this version, and can be made."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.harness import machine
from frictionbench.harness.plans import families
from frictionbench.harness.plans.suites import SPREAD, SUITES, drawn

SMALL = families.sources(families.ONE, families.SMALL, families.SPACE_ONE, families.SPACE_SMALL)


def test_problems_follow_from_the_digest() -> None:
    first, again, other = (drawn(SMALL, digest) for digest in ("a", "a", "b"))
    assert first == again
    assert all(one.parameters != two.parameters for one, two in zip(first, other, strict=True))
    assert all(one.parameters != own.parameters for one, own in zip(first, SMALL, strict=True))


def test_source_of_a_solver_decides(monkeypatch, tmp_path) -> None:
    before = SUITES["sealed"]().sources
    monkeypatch.setattr(machine, "PACKAGE", tmp_path)
    (tmp_path / "solvers").mkdir()
    (tmp_path / "solvers" / "mine.py").write_text("x = 1\n")
    machine.content.cache_clear()
    after = SUITES["sealed"]().sources
    machine.content.cache_clear()
    assert {source.scene for source in before} == {source.scene for source in after}
    assert before != after


@pytest.mark.parametrize("digest", ["a", "b", "c"])
def test_problems_can_be_made_and_stay_in_their_family(digest) -> None:
    for source, own in zip(drawn(SMALL, digest), SMALL, strict=True):
        assert fb.problem(source.scene, **source.parameters).contacts
        for name, value in own.parameters.items():
            if isinstance(value, float) and value:
                assert abs(np.log(source.parameters[name] / value)) < np.log(SPREAD) + 0.01
