"""Limits of joints and their dry friction as contacts, for every solver of this package.

A limit has no tangent: T = 0, mu = 0. Dry friction has no normal: N = 0, mu = 0, a bias > 0 and the friction bias h loss; its
normal impulse acts on nothing and is exactly zero.
"""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.solvers import Status, available, find, solve

TOL = 1e-8
OURS = sorted(name for name, info in available().items() if not info.needs)
LIMIT, DRY = 2, 3  # after two ordinary contacts
UNABLE = ("murty", 3)  # its guarantee is for P-matrices, which those of polygons are not: it stalls, and says so


def with_rows(dimension: int, rows: list[int], known: bool) -> FrictionProblem:
    """These of two contacts, a limit and dry friction, on six velocities; known: by its Delassus matrix only."""
    random, nv = np.random.default_rng(dimension), 6
    normal, tangent = random.standard_normal((4, nv)), random.standard_normal((4, dimension - 1, nv))
    tangent[LIMIT] = normal[DRY] = tangent[DRY, 1:] = 0.0
    problem = FrictionProblem(
        mass=np.diag(1 + random.random(nv)),
        normal=normal[rows],
        tangent=tangent[rows].reshape(-1, nv),
        friction=np.array([0.4, 0.3, 0.0, 0.0])[rows],
        free_velocity=random.standard_normal(nv) - 3 * normal[rows].sum(axis=0),
        bias=np.array([0.0, 0.0, 0.0, 1.0])[rows],
        friction_bias=np.array([0.0, 0.0, 0.0, 0.02])[rows],
        dimension=dimension,
    )
    if known:
        return FrictionProblem.from_delassus(problem.W, problem.q, problem.friction, dimension, problem.friction_bias)
    return problem


@pytest.mark.parametrize("rows", [[0, 1, LIMIT], [0, 1, DRY], [0, 1, LIMIT, DRY], [LIMIT], [DRY]], ids=str)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", OURS)
def test_rows_of_joints_are_solved(name, dimension, rows) -> None:
    info, _ = find(name)
    if dimension not in info.dimension:
        pytest.skip("not of this dimension")
    for known in (False, True):
        problem = with_rows(dimension, rows, known)
        answer = solve(problem, name, tol=TOL)
        if (name, dimension) == UNABLE and answer.status is Status.STALLED:
            continue
        assert answer.status is Status.SOLVED, answer.detail
        if info.model == "relaxation":
            assert relaxation_residual(problem, answer.impulse) <= TOL
        elif info.model == "lcp" and dimension == 3:
            assert problem.lcp().residual(answer.z) <= TOL
        else:
            assert residual(problem, answer.impulse) <= TOL
        if DRY in rows:
            assert answer.impulse[-1, 0] == 0.0
            assert answer.impulse[-1, 1] != 0.0
        if LIMIT in rows:
            assert not answer.impulse[rows.index(LIMIT), 1:].any()
