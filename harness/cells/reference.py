"""Reference answers, of which recorded problems, starts, motions and a problem's response are made. None is believed.

Solvers are asked in turn, each answer is verified like any other, and the first that holds is taken. Where none does there is
no reference, and what was to be made of it ends there, with the reason.
"""

from collections import Counter

import numpy as np

from frictionbench.harness.verify import verify
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.results.verdicts import Verdict
from frictionbench.solvers import available, solve

ASKED, ACCEPTED = 1e-10, 1e-8  # residuals: asked of the solver, and the most that is taken
ORDER = {2: ("lemke", "path_search", "interior_point"), 3: ("hybrid", "nsgs", "interior_point")}


class NoReference(Exception):  # noqa: N818  # a finding about the problem, which ends what it was for
    """No solver's answer holds; the message says how far each was off."""


class Reference:
    """A way to solve friction problems; str() says who answered how many of them."""

    def __init__(self) -> None:
        self._answered: Counter[str] = Counter()

    def __call__(self, problem: FrictionProblem) -> Array:
        """The impulses (nc, d). Errors: NoReference."""
        missed = []
        for name in ORDER[problem.dimension]:
            try:
                finding = verify(problem, answer := solve(problem, name, tol=ASKED), available()[name], ACCEPTED)
            except Exception as error:  # another may answer
                missed.append(f"{name}: {type(error).__name__}")
                continue
            if finding.verdict == Verdict.SOLVED:
                self._answered[name] += 1
                return np.asarray(answer.impulse, dtype=float)
            missed.append(f"{name}: {finding.residual:.1e}")
        raise NoReference(f"no reference answer within {ACCEPTED:g} ({', '.join(missed)})")

    def __str__(self) -> str:
        counts = self._answered.most_common()
        return counts[0][0] if len(counts) == 1 else ", ".join(f"{name} {count}" for name, count in counts)
