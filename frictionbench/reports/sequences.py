"""Times over the steps of one motion, for those who have to finish each step within a budget.

A motion is a scene, or a folder of recorded files in order, of which many steps were solved. Every problem counts the same.
"""

from typing import NamedTuple

import pandas as pd

from frictionbench.reports.accuracy import in_order, percentiles
from frictionbench.reports.recorded import file_of
from frictionbench.reports.run import Run
from frictionbench.results.conventions import scene_title

FEWEST = 20  # steps: of fewer the 99th percentile is the longest time


class Motion(NamedTuple):
    """A motion: its title, its number of problems, and its table of reports.accuracy.percentiles at the finest target."""

    title: str
    problems: int
    table: pd.DataFrame


def motions(run: Run) -> list[Motion]:
    """The motions of FEWEST steps or more, ranked ones only."""
    return [
        Motion(name, own["problem_id"].nunique(), in_order(percentiles(own, run.budget, weighted=False)))
        for name, own in step_times(run)
    ]


def step_times(run: Run) -> list[tuple[str, pd.DataFrame]]:
    """Of each motion its title and its times to the finest target (reports.accuracy.times_to), with the column step."""
    rows = run.ranked
    recorded = rows["parameters"].map(file_of) != ""
    titles = [scene_title(*names) for names in zip(rows["scene"], rows["parameters"], strict=True)]
    title = rows["scene"].where(recorded, pd.Series(titles, index=rows.index, dtype=object))
    of = pd.DataFrame({"title": title, "step": rows["step"]}).groupby(rows["problem_id"]).first()
    times = run.times[run.outer_targets[-1]]
    found = []
    for name, own in times.groupby(times["problem_id"].map(of["title"]), sort=False):
        steps = own["problem_id"].map(of["step"])
        if steps.nunique() >= FEWEST:
            found.append((str(name), own.assign(step=steps)))
    return found
