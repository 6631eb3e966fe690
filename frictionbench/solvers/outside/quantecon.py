"""QuantEcon's Lemke method: a dense tableau in numba, with lexicographic ratio tests.

Licence: MIT.
Form: the friction LCP's M, dense and scaled, and q. Setup: none. Solve: lcp_lemke's call.
Clock: none.
Charged: at 100 contacts 1.4 times a call by hand, where the scaled LCP takes more pivots.
Settings: tol_ratio_diff, within which two ratios are a tie, is 1e-13 by default; tuned is 1e-10, `frictionbench solve
    'stack[blocks=50,friction=0.05,push=1]' --solver 'quantecon' --solver 'quantecon[settings=tuned]'`.
Tolerance: it takes none; the solution of a basis is exact up to rounding.
Flaws: its status is unreliable in both directions: it reports a ray for problems that it has solved, `frictionbench solve
    'pyramid[rows=7,push=1]' --solver quantecon`, and success for inaccurate answers, `frictionbench solve
    'stack[blocks=5,mass_ratio=1e6,push=1]' --solver quantecon`. A dense tableau: time grows with the cube of the contacts.
Reference: Stachurski, Oyama and others, QuantEcon.py, quantecon.optimize.lcp_lemke.
"""

from importlib import import_module
from typing import Any

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

_TIES = {"default": 1e-13, "tuned": 1e-10}  # ratios that differ by less are a tie
_ENDED = {0: Status.SOLVED, 1: Status.WORK_LIMIT, 2: Status.RAY}


@solver(
    "quantecon",
    family="pivoting",
    model="lcp",
    dimension=(2, 3),
    needs=("quantecon",),
    variants=("settings=default", "settings=tuned"),
)
class QuantEcon:
    """Lemke's method by QuantEcon, a dense tableau in numba. (outside)

    settings: default or tuned. Work: pivots.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem | LCP) -> DenseLCP:
        return dense_lcp(problem)

    def solve(self, prepared: DenseLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        options = import_module("quantecon.optimize").PivOptions(tol_ratio_diff=_TIES[self.settings])
        lemke: Any = import_module("quantecon.optimize.lcp_lemke").lcp_lemke
        found = lemke(prepared.M, prepared.q, None, limit or 100_000, options)
        return prepared.scaled.answer(found.z, _ENDED.get(found.status, Status.FAILED), pivots=int(found.num_iter))
