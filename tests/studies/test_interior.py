"""Interior point on friction problems themselves, and a central path that folds, at reduced size."""

import numpy as np

from frictionbench.harness.studies.interior import central_path, folds
from frictionbench.problems.instances import make_instance
from tests.helpers.studies import reduced, told


def test_the_predictor_corrector_solves_most_problems() -> None:
    found = reduced(
        "interior",
        random={"frictions": (0.3, 3.0), "contacts": (5,), "seeds": 3},
        piles={"frictions": (0.2,), "blocks": (1, 10)},
        threshold={"ratios": (0.5, 3.0), "draws": 6},
        path={"frictions": (1.0,), "contacts": 3, "seeds": range(2)},
    )
    random, threshold = found["random"], found["threshold"]
    assert random.loc[random["friction"] < 1, ["plain", "paths", "relaxation"]].all().all()
    assert threshold["p0"].tolist() == [True, False]
    assert threshold.loc[threshold["p0"], "plain"].tolist() == [6]
    assert found["piles"]["plain"].all()
    assert found["path"]["t"].iloc[-1] < 1e-3
    assert told(found).answer.startswith("Yes")


def test_a_central_path_folds_and_ends_at_a_solution() -> None:
    lcp = make_instance("random", contacts=5, friction=10.0, seed=10).lcp()
    points = central_path(lcp)
    assert folds(points) >= 2
    assert points[-1][1] <= 1e-4
    assert np.all(np.diff([length for length, _ in points]) > 0)
