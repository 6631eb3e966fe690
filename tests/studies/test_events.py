"""Event-driven or time stepping, at reduced size."""

from tests.helpers.studies import reduced, told


def test_events_are_exact_and_steps_are_of_first_order() -> None:
    found = reduced(
        "events",
        errors={"names": ("bouncing_ball",), "counts": (20, 40, 80), "accuracies": (1e-6,)},
        ends={"cases": (("bouncing_ball", {"restitution": 0.5}, 2.0), ("painleve_rod", {}, 0.2))},
    )
    errors, ends = found["errors"], found["ends"]
    driven = errors["scheme"] == "event_driven"
    assert errors[driven]["error"].max() < 1e-9
    assert errors[~driven]["error"].min() > 1e-5
    assert ends["accumulations"].tolist() == [1, 0]
    assert ends["reached"].round(9).tolist() == [2.0, 0.0]
    assert "no bounded force" in ends["reason"][1]
    assert told(found).answer.startswith("Event-driven while events are few")
