"""Compliant or rigid, at reduced size."""

from tests.helpers.studies import reduced, told


def test_springs_tend_to_the_rigid_motion_and_decide_between_two() -> None:
    found = reduced(
        "compliance",
        stiffnesses={"names": ("stopping_block",), "values": (1e4, 1e5, 1e6), "methods": ("Radau",)},
        indentations={"shares": (0.5, 2.0)},
        inconsistent={"values": (1e4, 1e8)},
    )
    errors, stuck = found["stiffnesses"]["error"], found["inconsistent"]
    assert errors[2] < errors[1] < errors[0]
    off = (stuck["impulse"] / stuck["rigid"] - 1).abs()
    assert off[1] < off[0]
    assert off[1] < 0.02
    assert told(found).answer.startswith("Rigid where it has one answer")
