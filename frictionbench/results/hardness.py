"""Labels for what makes a problem hard: thresholds on the measured columns of its row.

Labels describe a problem, not any method. A column that was not measured (null) gives no label.
"""

import pandas as pd

from frictionbench.results.schema import cut

HIGH_CONDITION = 1e8  # condition number of W on its range at which a factorisation loses half of the digits of double precision

# One entry per label: its name, the condition on the columns, and its meaning with the reason for the threshold.
_LABELS = """
masses            mass_ratio >= 1e4            effective masses at the contacts differ by 1e4 or more, which slows sweeps down
friction          largest_friction >= 3        some friction coefficient is 3 or more, above those of dry surfaces
non-P0            p0_margin < 0                Painlevé's case: the LCP of some contact alone is not P0 (p0_margin below 0)
near p = 0        abs(p0_margin) <= 0.01       p0_margin is within 0.01 of 0: sliding allows almost any normal impulse
jam               pointedness > 1e-9           contacts can press on one another with nothing moving: impulses are unbounded
hyperstatic       dependent >= rows / 4 > 0    a quarter or more of W's rows are dependent: impulses are far from unique
ill-conditioned   condition >= @HIGH_CONDITION            the condition of W on its range is 1e8 or more: half of the digits
sensitive         sensitivity >= 1e4           the velocities change 1e4 times as much as the data or more
several outcomes  outcomes >= 2                the solutions have two or more distinct velocities
unlike islands    island_ratio >= 1e3          the largest closing speeds of two islands differ by 1e3 or more
large             contacts >= 100              100 contacts or more
"""
_CONDITIONS = {label: condition for label, condition, _ in cut(_LABELS, 18, 47)}
HARDNESS = {label: meaning for label, _, meaning in cut(_LABELS, 18, 47)}


def hardness(problems: pd.DataFrame) -> pd.DataFrame:
    """Return a column of booleans for each label. problems: rows of `solves`.

    An unknown rank of W is replaced by its bound, the number of velocities.
    """
    rows = problems["contacts"] * problems["dimension"]
    facts = problems.assign(rows=rows, dependent=problems["redundancy"].fillna(rows - problems["velocities"]))
    return pd.DataFrame({label: facts.eval(condition) for label, condition in _CONDITIONS.items()})
