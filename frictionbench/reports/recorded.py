"""Single problems: recorded ones with the solvers that solve them, and the steps of a motion, for users who have to finish each
step within a budget.

A recorded problem counts as solved if the residual of an answer at any tolerance is within the tightest tolerance of its rows.
A motion is a scene, or a folder of recorded files in order, of which many steps were solved, each with the same weight.
"""

from typing import Any, NamedTuple

import pandas as pd

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.reports.accuracy import in_order, percentiles
from frictionbench.reports.run import Run
from frictionbench.results.conventions import json_object, scene_title

FEWEST_STEPS = 20  # steps of a motion that is shown: as many as the suite `replay` takes of each


def recorded_problems(run: Run) -> list[dict[str, Any]]:
    """Return the recorded problems of the run, in the order of the plan: family, file and tol. reason: why the file yields no
    problem. Otherwise dimension, contacts (None for a bare LCP) and unknowns; solvers: those that solve it with their times, s,
    the fastest first; tried: how many ran."""
    files = run.rows["parameters"].map(file_of)
    recorded = run.rows.assign(file=files)[files != ""]
    groups = recorded.groupby(["scene", "file", "problem"], sort=False)
    return [{"family": family, "file": file, **_recorded(rows)} for (family, file, _), rows in groups]


def _recorded(rows: pd.DataFrame) -> dict[str, Any]:
    first, tol = rows.iloc[0], float(rows["tol"].min())
    if first["problem"] == "":
        return {"tol": tol, "reason": str(first["reason"])}
    done = rows[rows["answered"] & (rows["residual"] <= tol) & (rows["verdict"] != Verdict.UNJUDGEABLE)]
    contacts, dimension, unknowns = (None if pd.isna(first[n]) else int(first[n]) for n in ("contacts", "dimension", "size"))
    return {
        "dimension": dimension,
        "contacts": contacts,
        "unknowns": unknowns,
        "tol": tol,
        "solvers": done.groupby("label")["time"].min().sort_values().to_dict(),
        "tried": rows.loc[measured(rows), "label"].nunique(),
        "reason": "",
    }


def file_of(parameters: str) -> str:
    """Return the file that the parameters of a recorded problem name, empty for a scene."""
    values = json_object(parameters)
    return str(values["file"]) if list(values) == ["file"] else ""


class MotionTimes(NamedTuple):
    """A motion: its title, its number of problems, and its table of reports.accuracy.percentiles at the tightest target."""

    title: str
    problems: int
    table: pd.DataFrame


def motions(run: Run) -> list[MotionTimes]:
    """Return the motions with FEWEST_STEPS ranked steps or more."""
    return [
        MotionTimes(name, times["problem_id"].nunique(), in_order(percentiles(times, run.budget, weighted=False)))
        for name, times in step_times(run)
    ]


def step_times(run: Run) -> list[tuple[str, pd.DataFrame]]:
    """Return for each motion its title and its times to the tightest target (reports.accuracy.times_to) with the step."""
    rows = run.ranked
    recorded = rows["parameters"].map(file_of) != ""
    titles = [scene_title(*names) for names in zip(rows["scene"], rows["parameters"], strict=True)]
    title = rows["scene"].where(recorded, pd.Series(titles, index=rows.index, dtype=object))
    of = pd.DataFrame({"title": title, "step": rows["step"]}).groupby(rows["problem_id"]).first()
    times = run.times[run.outer_targets[-1]]
    times = times.assign(step=times["problem_id"].map(of["step"]))
    scenes = times.groupby(times["problem_id"].map(of["title"]), sort=False)
    return [(str(name), of_scene) for name, of_scene in scenes if of_scene["step"].nunique() >= FEWEST_STEPS]
