"""Times over the steps of one motion, for those who have to finish each step within a budget.

A motion is a scene, or a folder of recorded files in order, of which many steps were solved. Every problem counts the same.
"""

from typing import NamedTuple

import pandas as pd

from frictionbench.reports.accuracy import in_order, percentiles
from frictionbench.reports.recorded import file_of
from frictionbench.reports.run import Run
from frictionbench.results.cells import scene_title

FEWEST = 20  # steps: of fewer the 99th percentile is the longest time


class Motion(NamedTuple):
    """A motion: its title, its number of problems, and its table of reports.accuracy.percentiles at the finest target."""

    title: str
    problems: int
    table: pd.DataFrame


def motions(run: Run) -> list[Motion]:
    """The motions of FEWEST steps or more, ranked ones only."""
    rows = run.ranked
    recorded = rows["parameters"].map(file_of) != ""
    titles = [scene_title(*names) for names in zip(rows["scene"], rows["parameters"], strict=True)]
    title = rows["scene"].where(recorded, pd.Series(titles, index=rows.index, dtype=object))
    of = pd.DataFrame({"title": title, "step": rows["step"]}).groupby(rows["problem_id"]).first()
    times = run.times[run.outer_targets[-1]]
    found = []
    for name, own in times.groupby(times["problem_id"].map(of["title"]), sort=False):
        if own["problem_id"].map(of["step"]).nunique() >= FEWEST:
            table = in_order(percentiles(own, run.budget, weighted=False))
            found.append(Motion(str(name), own["problem_id"].nunique(), table))
    return found
