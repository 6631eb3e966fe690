"""Studies of made rows, and those at reduced size that take no seconds."""

import json

import pandas as pd
import pytest

import frictionbench as fb
from studies.neighbours import begin
from studies.rankings import summary
from studies.study import order
from studies.warm import COUNTS
from tests.helpers.studies import reduced, text

SPEEDS = {"nsgs": 1.0, "proximal_newton": 3.0, "siconos[method=friction_3d_nsn_ac]": 9.0, "interior_point": 2.0}


PROBLEMS = (("a", 0, False), ("b", 0, False), ("c", 3, False), ("d", 3, True))  # with redundancy, and whether idle


def runs(problems=PROBLEMS, end: str = "unsolved") -> pd.DataFrame:
    """Problems without full rank are of packed_spheres, and nonsmooth Newton ends so on them; nsgs fails at 1e-8."""
    rows = []
    for problem, redundancy, idle in problems:
        for tol in (1e-4, 1e-8):
            common = {"problem": problem, "tol": tol, "dimension": 3, "redundancy": redundancy, "trivial": False, "idle": idle}
            common |= {"form_time": 0.0, "setup_time": 0.0, "residual": 0.1, "contacts": 4, "velocities": 6}
            common |= {"scene": "packed_spheres" if redundancy else "cubes"}
            for name, time in SPEEDS.items():
                falls = (name == "nsgs" and tol == 1e-8) or ("nsn_ac" in name and redundancy)
                rows.append(common | {"variant": name, "verdict": end if falls else "solved", "solve_time": time})
            rows += [common | {"variant": name, "verdict": "relaxed", "solve_time": 0.02} for name in ("apgd", "relaxation_ip")]
    return pd.DataFrame(rows)


def test_each_finding_has_its_verdict() -> None:
    found = {"solves": runs(), "ranks": pd.DataFrame()}
    verdicts = {" ".join(row[0].split()[:2]): (row[1], row[-1]) for row in summary(found).numbers["rows"]}
    assert verdicts["Gauss-Seidel is"][0].startswith("nsgs solves 3 of 3"), "the idle problem is left out"
    broken = "3 of 3 answers of relaxation_ip break Coulomb's law, by a median residual of 0.1; its cost: see relaxation"
    assert verdicts["Approximations common"] == (f"{broken}; the gap to reality is not measured", "undecided")
    full = "Siconos' 2 of 2 with full rank, 0 of 1 without; 0 of the 1 missed end by the limit, which is no divergence"
    chance = "Fisher's one-sided exact test has p = 0.33, with 1 missed it cannot be below 0.33"
    assert verdicts["Nonsmooth Newton"] == (f"{full}; {chance}", "undecided"), "chance may explain it"
    assert text("rankings", found)["answer"].startswith("No method is within 2 times the fastest in more than 6 of 6 cases.")


def test_findings_without_the_problems_that_were_left_out() -> None:
    numbers = summary({"solves": runs(), "ranks": pd.DataFrame()}).numbers
    assert (numbers["added"], numbers["without"][1][1].startswith("nsgs solves 2 of 2")) == (1, True)
    assert (numbers["changed"], numbers["tally"]) == ("3", "confirmed 1, in part 1, contradicted 1 and undecided 2")


def test_newton_is_judged_where_chance_does_not_explain_what_it_misses() -> None:
    many = [(f"p{k}", 3 * (k % 2), False) for k in range(12)]
    for end, verdict in (("unsolved", "confirmed"), ("timeout", "in part")):  # the limit shows no divergence
        assert summary({"solves": runs(many, end), "ranks": pd.DataFrame()}).numbers["rows"][3][-1] == verdict


def rows(variant: str, warm: int, shuffled: int) -> list[dict[str, object]]:
    """Two motions of three problems; the first problem of each has no step before it."""
    return [
        {"variant": variant, "scene": scene, "problem": f"{scene}{k}", "step": k, "phase": "step", "start": start}
        | {"verdict": "solved", "work": json.dumps({COUNTS[variant]: count})}
        for scene in ("a", "b")
        for k in range(3)
        for start, count in (("cold", 1000 if k == 0 else 20), ("warm", warm), ("shuffled", shuffled))
        if k or start != "warm"
    ]


def test_only_problems_with_all_three_starts_are_compared() -> None:
    made = pd.DataFrame(rows("lemke", 5, 10) + rows("nsgs", 20, 30))
    account = text("warm", {"solves": made})
    assert account["answer"].startswith("From the step before, methods take 0.25 (0.25 to 0.25) for lemke to 1.00")
    assert "for 1 of 2 the interval of the ratio of sums is below 1" in account["answer"]
    assert "Of 4 problems with all three starts" in account["body"]
    made.loc[(made["variant"] == "nsgs") & (made["step"] == 2) & (made["start"] == "warm"), "verdict"] = "unsolved"
    assert "From the step before fewer problems are solved by nsgs." in text("warm", {"solves": made})["body"]


def test_neighbours_part_where_the_tip_leaves_and_by_the_order_of_hits() -> None:
    few = {"cases": ("rod at p < 0", "rod leaving at p < 0", "jam"), "schemes": ("anitescu_potra",)}
    few |= {"solvers": ("lemke", "interior_point"), "sizes": (1e-8, 1e-2)}
    spins = {"schemes": ("anitescu_potra", "event_driven"), "spins": (1e-6, 1e-4)}
    found = reduced("neighbours", ensembles=few, landings=spins)
    ends = found["ensembles"].query("size == 1e-8").set_index(["case", "solver"])["apart"]
    assert ends["rod at p < 0", "lemke"] < 1e-7
    assert (ends["rod leaving at p < 0"] > 1e-3).all()
    landings = found["landings"].set_index(["scheme", "spin"])
    assert landings.loc[("event_driven", 1e-6), "after"] == pytest.approx(landings["closed"].iloc[0], rel=0.01)
    assert landings.loc[("anitescu_potra", 1e-6), "after"] < 1e-5
    account = text("neighbours", found)
    assert "The cases are rod leaving at p &lt; 0 (anitescu_potra from 1e-08), where a tall block" in account["answer"]
    jam = begin("jam").problem()
    assert fb.residual(jam, 0 * fb.solve(jam, "lemke").impulse) > 0.5, "zero impulses are no solution"


def test_a_higher_order_is_kept_in_smooth_sliding_and_gaps_drift_less() -> None:
    schemes = ("anitescu_potra", "stewart_trinkle", "trapezoid")
    found = reduced("orders", errors={"schemes": schemes, "fractions": (3, 5, 10), "kinds": ("smooth sliding",)})
    own = dict(tuple(found["errors"].groupby("scheme")))
    assert abs(order(own["anitescu_potra"]["step"], own["anitescu_potra"]["error"]).value - 1) < 0.3
    drift = {name: order(rows["step"], rows["drift"]).value for name, rows in own.items()}
    assert 0.7 < drift["anitescu_potra"] < 1.4
    assert drift["stewart_trinkle"] > 1.7
    assert order(own["trapezoid"]["step"], own["trapezoid"]["error"]).value > 1.9
    assert "keeps its second order in smooth sliding" in text("orders", found)["answer"]
