"""Steps made smaller: the rod's impulse, the ledger's bound, and motions that settle, at reduced size."""

import numpy as np

from tests.helpers.studies import reduced, told


def test_the_rod_settles_within_the_ledgers_bound() -> None:
    arguments = {"scenes": ("rod",), "solvers": ("lemke", "interior_point"), "steps": (0.02, 0.01, 0.005)}
    rows = reduced("inclusion", refinement=arguments)
    table = rows["refinement"]
    assert (table["squares"] <= table["bound"]).all()
    away = np.abs(table.loc[table["solver"] == "lemke", "largest"] - 0.9)
    assert away.is_monotonic_decreasing
    assert away.iloc[-1] < 0.06
    assert "Each solver's sequence settles in 2 of 2 cases" in told(rows).answer
