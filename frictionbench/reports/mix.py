"""What the problems of a run are: the states of their contacts by size, and the problems that enter no ranking."""

import pandas as pd

from frictionbench.reports.accuracy import OVERALL
from frictionbench.reports.balance import decade
from frictionbench.reports.run import Run

STATES = ("sticking", "sliding", "open")


def mix(run: Run) -> pd.DataFrame:
    """A row per dimension and decade of contacts, of the problems that are ranked: problems, contacts, the shares of the
    contacts that stick, slide and are open in the reference answers, and unknown: problems without a reference answer."""
    facts = run.ranked.drop_duplicates("problem_id")
    if facts.empty:
        return pd.DataFrame()
    facts = facts.assign(where=facts["dimension"].map(OVERALL), decade=decade(facts["contacts"]))
    known = facts[list(STATES)].notna().all(axis=1)
    groups = facts.groupby(["where", "decade"])
    table = groups.agg(problems=("problem_id", "size"), contacts=("contacts", "sum"))
    table["unknown"] = (~known).groupby([facts["where"], facts["decade"]]).sum()
    sums = facts[known].groupby(["where", "decade"])[[*STATES]].sum()
    shares = sums.div(sums.sum(axis=1), axis=0)
    return table.join(shares).reset_index()


def left_out(run: Run) -> pd.DataFrame:
    """A row per scene with problems that enter no ranking: problems, how many are trivial, and how many of the others idle."""
    facts = run.rows[(run.rows["problem"] != "") & run.rows["contacts"].notna()].drop_duplicates("problem_id")
    facts = facts.assign(idle=facts["idle"] & ~facts["trivial"])
    table = facts.groupby("scene", sort=False).agg(
        problems=("problem_id", "size"), trivial=("trivial", "sum"), idle=("idle", "sum")
    )
    return table[(table["trivial"] > 0) | (table["idle"] > 0)].reset_index()


def idle_share(run: Run) -> float:
    """The share of idle problems among those that are ranked, 0 where they are left out as they should be."""
    facts = run.ranked.drop_duplicates("problem_id")
    return float(facts["idle"].mean()) if len(facts) else 0.0
