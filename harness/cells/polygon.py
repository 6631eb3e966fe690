"""The model error of polygonal friction on a motion: the ball of problems.ball, simulated with the cone and with polygons.

Each answer is verified as one of its own model, so that what remains is the model error and the time discretisation error: the
path with the cone differs from the parabola to first order in the step.
"""

from functools import partial

from frictionbench.harness.verify import verify
from frictionbench.problems import FrictionProblem
from frictionbench.problems.ball import apart, slide
from frictionbench.problems.check import Array
from frictionbench.results.polygon import Deviation
from frictionbench.solvers import find, solve

CONE = "interior_point"  # solves spatial problems with the cone to TOLERANCE
FACETS = (4, 6, 8, 16, 32, 64)  # from the coarsest in use to one whose model error is hardly visible
STEP = 0.002  # s: small, so that the discretisation error does not hide the polygons'
TOLERANCE = 1e-8  # far below the model errors


def measure() -> list[Deviation]:
    """The deviation with the cone, then with each polygon. Errors: ArithmeticError where an answer does not solve its model."""
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
        raise ArithmeticError(f"{spec}: {answer.status.value}; the residual of its model is {finding.model_residual:.1e}")
    return answer.impulse
