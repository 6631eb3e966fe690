"""Solution sets that are not convex, and how rare they are, at reduced size."""

from tests.helpers.studies import reduced, told


def test_the_jam_is_a_bent_line_and_the_block_is_unique_where_it_is_p0() -> None:
    found = reduced(
        "convexity",
        jam={"points": 9},
        block={"frictions": (0.5, 3.0), "aspects": (1.0,), "draws": 30},
        motions={"names": ("example_4",), "steps": 30, "most": 3},
    )
    jam, block, scenes = found["jam"], found["block"], found["scenes"]
    assert jam["residual"].max() < 1e-12
    assert (jam["middle_residual"] > 1e-3).tolist() == (jam["share"] > 1).tolist()
    assert jam["middle_gap"].iloc[-1] == 0.25
    assert block["several_velocities"].gt(0).tolist() == [False, True]
    assert {"jam", "wedge"} == {*scenes.loc[scenes["impulses"] == "not convex", "scene"]}
    account = told(found)
    assert account.answer.startswith("No. ")
    assert [figure.name for figure in account.figures] == ["jam", "block"]
