"""Reference answers, from which problems, starts, motions and sensitivities are computed.

Solvers are tried in turn, and the first answer that is verified as solved is used. If there is none, the problem has no
reference answer, and the motion or sensitivity ends there with the reason.
"""

from collections import Counter
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.verdicts import Verdict
from frictionbench.problems.verify import verify
from frictionbench.solvers import available, solve

T = TypeVar("T")
TOL = 1e-10  # the tolerance given to solvers
LARGEST_RESIDUAL = 1e-8  # of an accepted answer: the tightest target of most suites
# In the order tried: an exact method first, then methods of other kinds, which fail on other problems.
SMALL_PLANAR = ("lemke", "path_search", "interior_point")
GENERAL = ("hybrid", "nsgs", "interior_point")
LARGE_PLANAR = ("interior_point", "nsgs")
DENSE = 100  # contacts of a planar problem above which dense bases take longer than a sparse method
DENSEST = 400  # contacts of a planar problem above which dense bases take minutes, in hybrid too


class NoReference(Exception):  # noqa: N818  # no error but a result about the problem
    """No solver's answer is verified as solved; the message gives the residual of each."""


class Reference:
    """Solves friction problems; str() gives the solvers used and how often."""

    def __init__(self) -> None:
        self._answered: Counter[str] = Counter()

    def __call__(self, problem: FrictionProblem) -> Array:
        """The impulses (nc, d). Errors: NoReference."""
        failed = []
        for name in _names(problem):
            try:
                finding = verify(problem, answer := solve(problem, name, tol=TOL), available()[name].model, LARGEST_RESIDUAL)
            except Exception as error:  # the next solver is tried
                failed.append(f"{name}: {type(error).__name__}")
                continue
            if finding.verdict == Verdict.SOLVED:
                self._answered[name] += 1
                return np.asarray(answer.impulse, dtype=float)
            failed.append(f"{name}: {finding.residual:.1e}")
        raise NoReference(f"no reference answer within {LARGEST_RESIDUAL:g} ({', '.join(failed)})")

    def __str__(self) -> str:
        counts = self._answered.most_common()
        return counts[0][0] if len(counts) == 1 else ", ".join(f"{name} {count}" for name, count in counts)


def unless_unsolved(otherwise: T, find: Callable[[Reference], T]) -> T:
    """Return find(Reference()), or `otherwise` if a problem in it has no reference answer."""
    try:
        return find(Reference())
    except NoReference:
        return otherwise


def reference_answer(problem: FrictionProblem) -> Array | None:
    """Return the impulses (nc, d) of the reference answer, or None if there is none."""
    return unless_unsolved(None, lambda solve: solve(problem))


def _names(problem: FrictionProblem) -> tuple[str, ...]:
    """Return the solvers to try in turn."""
    if problem.dimension == 3 or DENSE < problem.contacts <= DENSEST:
        return GENERAL
    return SMALL_PLANAR if problem.contacts <= DENSE else LARGE_PLANAR
