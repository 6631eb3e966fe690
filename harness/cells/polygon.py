"""The polygon's error on a motion: the ball of problems.ball, moved by answers with the cone and with polygons in its place.

Each answer is verified as that of its own model, so that what is left is the model's error, and the step's: the path with the
cone misses the parabola to first order in the step.
"""

from functools import partial

from frictionbench.harness.verify import verify
from frictionbench.problems import FrictionProblem
from frictionbench.problems.ball import apart, slide
from frictionbench.problems.check import Array
from frictionbench.results.polygon import Deviation
from frictionbench.solvers import find, solve

CONE = "interior_point"
FACETS = (4, 6, 8, 16, 32, 64)
STEP = 0.002  # s
TOLERANCE = 1e-8


def measure() -> list[Deviation]:
    """The cone's row, then one of each polygon. Errors: ArithmeticError where an answer does not solve its model."""
    cone, parabola = slide(partial(_verified, CONE), STEP)
    found = [Deviation(0, STEP, apart(cone, parabola), 0.0)]
    for facets in FACETS:
        path, _ = slide(partial(_verified, f"lemke[facets={facets}]"), STEP)
        found.append(Deviation(facets, STEP, apart(path, parabola), apart(path, cone)))
    return found


def _verified(spec: str, problem: FrictionProblem) -> Array:
    answer = solve(problem, spec, tol=TOLERANCE)
    finding = verify(problem, answer, find(spec)[0], TOLERANCE)
    if not min(finding.residual, finding.model_residual) <= TOLERANCE:
        raise ArithmeticError(f"{spec}: {answer.status.value}; its model's residual is {finding.model_residual:.1e}")
    return answer.impulse
