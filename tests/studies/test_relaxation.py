"""The relaxation's two artefacts, its small cost in motions, and the cycle of the fixed point, at reduced size."""

import numpy as np

from tests.helpers.studies import reduced, told


def test_the_relaxation_errs_and_the_fixed_point_cycles() -> None:
    found = reduced(
        "relaxation",
        errors={"frictions": (0.1, 0.4, 0.8), "steps": (1e-3,)},
        cycle={"frictions": (0.45, 0.75, 1.0), "rounds": 100},
        gaps={"steps": (0.02, 0.01, 0.005)},
        stopping={"frictions": (0.6,), "steps": (0.02, 0.01)},
        falls={"frictions": (0.7,), "speeds": (1.0, 3.0), "steps": 100},
    )
    cycle, gaps, stopping, falls = (found[name] for name in ("cycle", "gaps", "stopping", "falls"))
    assert cycle["cycles"].tolist() == [False, True, False]
    assert cycle["staggered"].eq("solved").all()
    assert gaps["coulomb"].max() < 1e-9
    assert np.allclose(gaps["smooth"], gaps["smooth_predicted"], rtol=0.02)
    assert np.ptp(gaps["hop"]) < 0.2 * gaps["hop"].min()
    assert np.allclose(stopping["coulomb"], stopping["exact"] - stopping["step"] / 2, rtol=0.03)
    assert falls["coulomb"].tolist() == falls["relaxed"].tolist() == [False, True]
    assert found["errors"]["error"].median() > 0.05
    found["gaps"]["hop_predicted"] = gaps["hop"]  # the steps are too large for the limit
    assert told(found).answer.startswith("Not in one")
