"""How many velocities the answers of a run have."""

import numpy as np
import pandas as pd

from frictionbench.reports.run import outcomes


def test_outcomes_are_counted_by_problem() -> None:
    distances = {
        "one": [1e-9, 1e-12, 5e-4, np.nan],
        "two": [0.0, 0.3, 0.3 + 1e-9, np.nan],
        "three, one of them between": [0.05, 0.0, 0.3, 0.3001],
        "unknown": [np.nan] * 4,
        "enumerated": [0.0] * 4,
        "infinitely many": [0.0] * 4,
    }
    solutions = {"enumerated": ("one", 1.0), "infinitely many": ("convex", np.nan)}
    rows = pd.DataFrame(
        [
            {"problem": name, "outcome_distance": each, "solutions": shape, "outcomes": count}
            for name, values in distances.items()
            for shape, count in [solutions.get(name, (None, np.nan))]
            for each in values
        ]
    )
    found = rows.assign(found=outcomes(rows)).drop_duplicates("problem")["found"]
    assert found.fillna(-1).tolist() == [1, 2, 3, -1, 1, 1]
