"""Published rankings under one verifier; runs are made rows."""

import pandas as pd

from studies.rankings import summary
from tests.helpers.studies import text

SPEEDS = {"nsgs": 1.0, "proximal_newton": 3.0, "siconos[method=friction_3d_nsn_ac]": 9.0, "interior_point": 2.0}


def runs() -> pd.DataFrame:
    """Three problems that need friction, the last without full rank, and one that needs none; nsgs fails at 1e-8."""
    rows = []
    for problem, redundancy, idle in (("a", 0, False), ("b", 0, False), ("c", 3, False), ("d", 3, True)):
        for tol in (1e-4, 1e-8):
            common = {"problem": problem, "tol": tol, "dimension": 3, "redundancy": redundancy, "trivial": False, "idle": idle}
            common |= {"form_time": 0.0, "setup_time": 0.0, "residual": 0.1, "contacts": 4, "velocities": 6}
            for name, time in SPEEDS.items():
                falls = (name == "nsgs" and tol == 1e-8) or ("nsn_ac" in name and redundancy)
                rows.append(common | {"variant": name, "verdict": "unsolved" if falls else "solved", "solve_time": time})
            rows += [common | {"variant": name, "verdict": "relaxed", "solve_time": 0.02} for name in ("apgd", "relaxation_ip")]
    return pd.DataFrame(rows)


def test_each_finding_has_its_verdict() -> None:
    found = {"solves": runs()}
    verdicts = {" ".join(row[0].split()[:2]): (row[1], row[-1]) for row in summary(found).numbers["rows"]}
    assert verdicts["Gauss-Seidel is"][0].startswith("nsgs solves 3 of 3"), "the idle problem is left out"
    broken = "3 of 3 answers of relaxation_ip break Coulomb's law, by a median residual of 0.1; its cost: see relaxation"
    assert verdicts["Approximations common"] == (broken, "in part"), "no reality is in the problems"
    full = "Siconos' 2 of 2 with full rank, 0 of 1 without; 0 of the 1 missed end by the limit, which is no divergence"
    chance = "Fisher's one-sided exact test has p = 0.33, with 1 missed it cannot be below 0.33"
    assert verdicts["Nonsmooth Newton"] == (f"{full}; {chance}", "in part")
    assert text("rankings", found).answer.startswith("interior_point is within 2 times the fastest in 100 % of cases.")
