"""The model error of polygonal friction on a motion: the scene sliding_ball, simulated with the cone and with polygons.

Each answer is verified as one of its own model, so that what remains is the model error and the time discretisation error: the
path with the cone differs from the parabola to first order in the step.
"""

from functools import partial

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import simulate
from frictionbench.problems.verify import verify
from frictionbench.results.extras import Deviation
from frictionbench.solvers import find, solve

CONE = "interior_point"  # solves spatial problems with the cone to TOLERANCE
FACETS = (4, 6, 8, 16, 32, 64)  # from the coarsest in use to one whose model error is hardly visible
STEP = 0.002  # s: small, so that the discretisation error does not hide the polygons'
SLIDING = 0.236  # s, until the ball rolls
TOLERANCE = 1e-8  # far below the model errors


def measure() -> list[Deviation]:
    """The deviation with the cone, then with each polygon. Errors: ArithmeticError where an answer does not solve its model."""
    ball = scene("sliding_ball", step=STEP, duration=SLIDING)
    assert ball.path is not None
    parabola = np.vstack([ball.path(step * STEP) for step in range(ball.steps + 1)])

    def path(spec: str) -> Array:
        return np.vstack([ball.geometry.centres(step.q) for step in simulate(ball, partial(_verified, spec))])

    cone = path(CONE)
    found = [Deviation(0, STEP, _apart(cone, parabola), 0.0)]
    for facets in FACETS:
        bent = path(f"lemke[facets={facets}]")
        found.append(Deviation(facets, STEP, _apart(bent, parabola), _apart(bent, cone)))
    return found


def _apart(one: Array, other: Array) -> float:
    """The largest distance of two paths at the same times, m."""
    return float(np.linalg.norm(one - other, axis=1).max())


def _verified(spec: str, problem: FrictionProblem) -> Array:
    answer = solve(problem, spec, tol=TOLERANCE)
    finding = verify(problem, answer, find(spec)[0].model, TOLERANCE)
    if not min(finding.residual, finding.model_residual) <= TOLERANCE:
        raise ArithmeticError(f"{spec}: {answer.status.value}; the residual of its model is {finding.model_residual:.1e}")
    return answer.impulse
