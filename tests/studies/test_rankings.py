"""Published rankings under one verifier, at reduced size; runs are made rows."""

import pandas as pd
import pytest

from frictionbench.harness import families
from frictionbench.results import ResultsError
from studies.rankings import summary
from studies.study import Tables
from tests.helpers.studies import reduced, text

pytestmark = pytest.mark.slow  # sentences on rankings: half a minute of solvers by every method

SPEEDS = {"nsgs": 1.0, "proximal_newton": 3.0, "siconos[method=friction_3d_nsn_ac]": 9.0, "interior_point": 2.0}


def runs(nsgs: str = "unsolved") -> pd.DataFrame:
    """Three problems that need friction, the last without full rank, and one that needs none; nsgs ends so at 1e-8."""
    rows = []
    for problem, redundancy, idle in (("a", 0, False), ("b", 0, False), ("c", 3, False), ("d", 3, True)):
        for tol in (1e-4, 1e-8):
            common = {"problem": problem, "tol": tol, "dimension": 3, "redundancy": redundancy, "trivial": False, "idle": idle}
            common |= {"form_time": 0.0, "setup_time": 0.0, "residual": 0.1, "contacts": 4, "velocities": 6}
            for name, time in SPEEDS.items():
                falls = (name == "nsgs" and tol == 1e-8) or ("nsn_ac" in name and redundancy)
                rows.append(common | {"variant": name, "verdict": nsgs if falls else "solved", "solve_time": time})
            rows += [common | {"variant": name, "verdict": "relaxed", "solve_time": 0.02} for name in ("apgd", "relaxation_ip")]
    return pd.DataFrame(rows)


@pytest.fixture(scope="module")
def found() -> Tables:
    every = families.sources(families.SPACE_SMALL)
    small = [one for one in every if one.scene != "random_bodies"]
    return reduced("rankings", {"solves": runs()}, ranks={"sources": [every[2], *small[:1], *small[2:3]]})


def test_newton_needs_rank_and_nothing_needs_iterations_without_friction(found) -> None:
    ranks, evidence = found["ranks"], found["evidence"]
    plain = ranks[ranks["method"] == "plain_newton"].groupby("compliance")["solved"].sum()
    least = ranks[ranks["method"] == "least_newton"].groupby("compliance")["solved"].sum()
    assert plain[0.0] < plain[0.001] == ranks["number"].nunique() == least[0.0]
    assert (evidence.loc[~evidence["idle"], "iterations"] > 0).all()
    given = evidence[evidence["idle"] & (evidence["start"] == "given") & (evidence["iterations"] == 0)]
    assert given.groupby("kind")["residual"].apply(lambda own: own.value_counts().iloc[0]).min() >= 6


def test_each_finding_has_its_verdict(found) -> None:
    rows = summary(found).numbers["rows"]
    verdicts = {row[0].split(" (")[0]: (row[1], row[-1]) for row in rows}
    short = verdicts["It does not solve all problems to 1e-8 within the time limit"]
    assert short == ("nsgs solves 0 of 3", "confirmed"), "the idle problem is left out"
    relaxed = verdicts["Approximations common in robotics can widen the gap to reality"]
    broken = "3 of 3 answers of relaxation_ip break Coulomb's law, by a median residual of 0.1; its cost: see relaxation"
    assert relaxed == (broken, "in part"), "no reality is in the problems"
    tens = verdicts["Accelerated gradients are one or two orders faster than Gauss-Seidel in large systems"]
    assert tens == ("apgd's speed over nsgs', median: 50 with below 10 contacts (3)", "not tested")
    assert all(row[2] in ("needs --data", "not repeated") for row in rows)
    assert "needs a folder of them (--data)" in text("rankings", found).body


def test_sentences_that_the_tables_do_not_hold_are_refused(found) -> None:
    working = found["evidence"].assign(iterations=0)
    with pytest.raises(ResultsError, match="no method is without iterations where friction is at work"):
        text("rankings", {**found, "evidence": working})
