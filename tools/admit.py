"""Choose the suite `hard` from its candidates by the rule of docs/hard.md: its hard.tsv, and the answers in answers.npz.

The candidates, in candidates.tsv, come from the extremes of families: "around p = 0" has Painlevé's rod near the friction at
which 1 + 3 cos^2 = 3 mu sin cos of its angle; "recorded" has problems recorded elsewhere.

    python -m tools.admit DIR

runs every candidate with every method in DIR (about a quarter of an hour on one core), or resumes an interrupted run.
"""

import csv
import json
import sys
from collections import defaultdict
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import frictionbench as fb
from frictionbench.harness.cells.stored import stored_friction
from frictionbench.harness.plans import hard
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run as run_plan
from frictionbench.problems import Verdict
from frictionbench.results.store import rows

COLUMNS = ("family", "scene", "parameters", "contacts", "known", "residual", "floor", "answer", "failed")
FAILED = (Verdict.NEAR_MISS, Verdict.UNJUDGEABLE, Verdict.UNSOLVED, Verdict.CRASHED, Verdict.WRONG)
PROVEN = ("gaps", "pointed", "counted")  # values of the column `existence` that mean a proof
FLOOR = hard.TOL / 10
LIMIT = 10.0  # seconds
FEWEST = 4
CANDIDATES, ANSWERS = (Path(__file__).with_name(name) for name in ("candidates.tsv", "answers.npz"))

Record = dict[str, Any]


def admit(folder: Path) -> None:
    """Run the candidates of both dimensions in folder, choose, and write the two files."""
    lines: list[Record] = []
    answers: dict[str, NDArray[np.float64]] = {}
    for dimension in (2, 3):
        place = folder / f"dimension_{dimension}"
        run_plan(candidates(dimension), place, 1, Progress())
        by_problem: dict[tuple[str, str], list[Record]] = defaultdict(list)
        for row in rows(place, "solves").values():
            by_problem[row["scene"], row["parameters"]].append(row)
        for family, sources in families(dimension).items():
            own = [by_problem[source.scene, json.dumps(source.parameters, sort_keys=True)] for source in sources]
            for found in fewest_contacts([each for each in own if admissible(each)]):
                line, answer = _line(family, found, stored_friction(place, found[0]["problem"]))
                lines.append(line)
                if answer is not None:
                    answers[answer_key(line)] = answer
    with hard.ADMITTED.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, delimiter="\t", lineterminator="\n", quoting=csv.QUOTE_NONE, quotechar=None)
        writer.writeheader()
        writer.writerows(lines)
    np.savez_compressed(ANSWERS, allow_pickle=False, **answers)


def candidates(dimension: int) -> Plan:
    """Return the plan of all candidates of a dimension, with the methods whose model is exact there."""
    return Plan(
        suite=f"candidates for hard, dimension {dimension}",
        sources=tuple(source for family in families(dimension).values() for source in family),
        solvers=hard.METHODS[:-1] if dimension == 2 else hard.METHODS[4:],
        tolerances=(hard.TOL,),
        time_limit=LIMIT,
    )


def families(dimension: int) -> dict[str, list[Source]]:
    """Return the candidates by family: a source for every combination of the values in a row of candidates.tsv."""
    found: dict[str, list[Source]] = {}
    for row in hard.table(CANDIDATES):
        if int(row["dimension"]) == dimension:
            grid = json.loads(row["grid"])
            chosen = (dict(zip(grid, values, strict=True)) for values in product(*grid.values()))
            found.setdefault(row["family"], []).extend(Source(row["scene"], each, repeats=1) for each in chosen)
    return found


def kept_answer(row: Record) -> NDArray[np.float64] | None:
    """Return the verified impulses (nc, d) stored for a row of hard.tsv; None if a solution is known only by theory."""
    if not row["answer"]:
        return None
    with np.load(ANSWERS, allow_pickle=False) as answers:
        return answers[answer_key(row)]


def answer_key(row: Record) -> str:
    """The name of a row's answer in answers.npz."""
    return f"{row['scene']} {row['parameters']}"


def failures(rows: list[Record]) -> dict[str, str]:
    """The verdict of each method that failed on a problem."""
    return {row["variant"]: row["verdict"] for row in rows if row["verdict"] in FAILED}


def admissible(rows: list[Record]) -> bool:
    """Return whether a problem, given by all its rows, may be in the suite by the rule of docs/hard.md."""
    first = rows[0]
    if not first["problem"] or first["trivial"] or first["idle"] or not failures(rows):
        return False
    solved = any(row["verdict"] == Verdict.SOLVED for row in rows) and first["existence"] != "none"
    best = min(rows, key=_distance)
    known = first["existence"] in PROVEN or solved
    return known and (best.get("residual_floor") or 0.0) <= FLOOR


def fewest_contacts(problems: list[list[Record]]) -> list[list[Record]]:
    """Return, for each method, the FEWEST smallest problems of a family on which it fails, in the family's order."""
    taken: dict[str, list[int]] = defaultdict(list)
    for index in sorted(range(len(problems)), key=lambda i: problems[i][0]["contacts"]):
        for method in failures(problems[index]):
            taken[method].append(index)
    return [problems[index] for index in sorted({index for indices in taken.values() for index in indices[:FEWEST]})]


def _line(family: str, rows: list[Record], problem: fb.FrictionProblem) -> tuple[Record, NDArray[np.float64] | None]:
    """Return a row of hard.tsv, and the best answer if it is verified."""
    best = min(rows, key=_distance)
    answer = fb.solve(problem, best["variant"], tol=hard.TOL).impulse if best["verdict"] == Verdict.SOLVED else None
    found = best["residual"] if answer is None else fb.residual(problem, answer)
    floor = best["residual_floor"] if answer is None else fb.residual_floor(problem, answer)
    known = ", ".join(filter(None, [rows[0]["existence"], "answer" if answer is not None else ""]))
    failed = ", ".join(f"{method} {verdict}" for method, verdict in failures(rows).items())
    line = {name: rows[0][name] for name in ("scene", "parameters", "contacts")}
    line |= {"family": family, "known": known, "residual": f"{found:.1e}", "floor": f"{floor:.1e}"}
    return line | {"answer": best["variant"] if answer is not None else "", "failed": failed}, answer


def _distance(row: Record) -> float:
    value = row.get("residual")
    return np.inf if value is None or np.isnan(value) else value


if __name__ == "__main__":
    admit(Path(sys.argv[1]))
