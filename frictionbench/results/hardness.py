"""What makes a problem hard, from the measured columns of its row: a set of labels, each with its threshold.

Labels state facts about a problem, not about any method. A column that was not measured (null) gives no label.
"""

from pathlib import Path

import pandas as pd

from frictionbench.results.schema import cut

ILL = 1e8  # condition of W on its range, at which a factorisation loses half of the digits of double precision

# A line for each label: its name, the condition on the columns, and its meaning with the reason for the threshold.
_LABELS = [*cut(Path(__file__).with_name("hardness.txt").read_text(encoding="utf-8"), 18, 47)]
_CONDITIONS = {label: condition for label, condition, _ in _LABELS}
HARDNESS = {label: meaning for label, _, meaning in _LABELS}  # the labels in their order


def hardness(problems: pd.DataFrame) -> pd.DataFrame:
    """A column for each label, whether a problem has it. problems: rows of `solves`.

    Where the rank of W is unknown it is at most the number of velocities.
    """
    rows = problems["contacts"] * problems["dimension"]
    facts = problems.assign(rows=rows, dependent=problems["redundancy"].fillna(rows - problems["velocities"]))
    return pd.DataFrame({label: facts.eval(condition) for label, condition in _CONDITIONS.items()})
