"""Which motion was found: how many velocities the verified answers of a run have, problem by problem.

Answers are compared by their distance from one reference (columns outcome_distance, problems.analysis.outcomes). Velocities at
distances that differ by more than APART are apart by at least as much; velocities at the same distance may differ, so that the
number is a lower bound.
"""

import numpy as np
import pandas as pd

APART = 1e-3  # of what contact changes


def with_outcomes(rows: pd.DataFrame) -> pd.DataFrame:
    """A copy of the table of solves with two columns of the problem.

    outcomes_found: at least so many velocities have the answers of the run, the reference included; NaN where none is known.
    one_outcome: there is one velocity by enumeration, or no second was found and none was enumerated.
    """
    known = rows.loc[rows["outcome_distance"].notna(), ["problem", "outcome_distance"]]
    counted = known.groupby("problem")["outcome_distance"].agg(_apart)
    found = rows["problem"].map(counted).astype(float)
    enumerated = rows["solutions"].fillna("").ne("")
    return rows.assign(outcomes_found=found, one_outcome=np.where(enumerated, rows["outcomes"].eq(1), found.eq(1)).astype(bool))


def _apart(distances: pd.Series) -> int:
    """How many groups of distances there are, with that of the reference, 0."""
    return 1 + int((np.diff(np.sort(distances.to_numpy(float)), prepend=0.0) > APART).sum())
