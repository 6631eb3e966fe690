"""Orders and drift of two schemes on smooth sliding, at reduced size."""

from frictionbench.reports.studies.numbers import order
from tests.helpers.studies import reduced, told


def test_sliding_is_of_first_order_and_gaps_drift_less() -> None:
    schemes = ("anitescu_potra", "stewart_trinkle")
    found = reduced("orders", errors={"schemes": schemes, "steps": (0.04, 0.02, 0.01), "kinds": ("smooth sliding",)})
    own = dict(tuple(found["errors"].groupby("scheme")))
    assert abs(order(own["anitescu_potra"]["step"], own["anitescu_potra"]["error"]).value - 1) < 0.3
    drift = {name: order(rows["step"], rows["drift"]).value for name, rows in own.items()}
    assert 0.7 < drift["anitescu_potra"] < 1.4
    assert drift["stewart_trinkle"] > 1.7
    assert told(found).answer.startswith("No scheme")
