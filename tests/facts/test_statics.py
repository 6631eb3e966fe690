"""Single steps whose solution is known from statics or textbook mechanics."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.analysis.polyhedra import Shape
from frictionbench.problems.residual import residual
from frictionbench.solvers import Status, solve

G, H = 9.81, 0.01


@pytest.mark.parametrize("mu", [0.2, 0.7])
@pytest.mark.parametrize("factor", [0.5, 0.999, 1.0, 1.001, 1.5])
def test_incline(mu, factor) -> None:
    """A particle at rest sticks iff mu >= tan(angle), and else starts at g (sin - mu cos)."""
    angle = np.arctan(mu * factor)
    down = G * np.array([np.sin(angle), -np.cos(angle)])
    problem = FrictionProblem(
        mass=3 * np.eye(2), normal=[[0, 1]], tangent=[[1, 0]], friction=[mu], free_velocity=H * down, bias=[0]
    )
    found = census(problem)
    assert found.count == 1
    start = max(0.0, G * (np.sin(angle) - mu * np.cos(angle)))
    assert found.velocities[0].vertices == pytest.approx(np.array([[0, H * start]]), abs=1e-14)
    assert (start > 1e-9) == (factor > 1)


def rocking(alpha, mu) -> FrictionProblem:
    """A block 2b by 2h, tan(alpha) = b/h, that rocks about its left corner as the right one hits the ground; omega = -1."""
    b, h = np.sin(alpha), np.cos(alpha)
    return FrictionProblem(
        mass=np.diag([1, 1, 1 / 3]),  # half diagonal 1
        normal=[[0, 1, -b], [0, 1, b]],
        tangent=[[1, 0, h]] * 2,
        friction=[mu] * 2,
        free_velocity=[h, -b, -1.0],  # the left corner (-b, -h) stays where it is
        bias=[0, 0],
    )


@pytest.mark.parametrize("alpha", [0.2, 0.4, 0.6])
def test_housners_rocking_block(alpha) -> None:
    """omega+/omega- = 1 - 1.5 sin^2(alpha), without slip iff mu >= 3 t/(4 + t^2), t = tan(alpha)."""
    t = np.tan(alpha)
    least = 3 * t / (4 + t * t)
    for factor, slips in ((1.02, False), (0.98, True), (3.0, False)):
        problem = rocking(alpha, least * factor)
        assert problem.q == pytest.approx([0, 0, -2 * np.sin(alpha), 0], abs=1e-12)
        found = census(problem)
        outcomes = []
        for piece in found.pieces:
            r = piece.vertices[0].reshape(2, 2)
            v, u = problem.velocity(r), problem.contact_velocity(r)
            outcomes.append((v[2], u[1, 1], r[0, 0]))
        omega, slip, left = outcomes[0]
        assert len(outcomes) == 1
        assert left == pytest.approx(0, abs=1e-12)
        assert (abs(slip) > 1e-6) == slips
        if not slips:
            assert omega == pytest.approx(-(1 - 1.5 * np.sin(alpha) ** 2))


def test_a_table_on_four_legs() -> None:
    """N = m g h/4 + s (+, -, +, -) for any s: only the resultant and the velocity are determined."""
    m, corners = 8.0, np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    normal = np.column_stack([np.zeros((4, 2)), np.ones(4), corners[:, 1], -corners[:, 0], np.zeros(4)])
    tangent = np.zeros((8, 6))
    tangent[::2, 0], tangent[1::2, 1] = 1, 1
    tangent[::2, 5], tangent[1::2, 5] = -corners[:, 1], corners[:, 0]
    table = FrictionProblem(
        mass=np.diag([m, m, m, 2, 2, 3]),
        normal=normal,
        tangent=tangent,
        friction=[0.5] * 4,
        free_velocity=[0, 0, -G * H, 0, 0, 0],
        bias=[0] * 4,
        dimension=3,
    )
    weight = m * G * H
    for s in (0.0, 0.1, -0.24):
        r = np.zeros((4, 3))
        r[:, 0] = weight * (0.25 + s * np.array([1, -1, 1, -1]))
        assert residual(table, r) <= 1e-12
    for spec in ("nsgs", "lemke"):
        answer = solve(table, spec, tol=1e-10)
        assert answer.status is Status.SOLVED
        assert answer.impulse[:, 0].sum() == pytest.approx(weight)
        assert table.contact_velocity(answer.impulse) == pytest.approx(np.zeros((4, 3)), abs=1e-10)


def test_planar_table_on_three_legs() -> None:
    """The same in the plane, where the census shows the whole segment: N = (s, mgh - 2s, s)."""
    problem = FrictionProblem(
        mass=np.diag([1, 1, 0.5]),
        normal=[[0, 1, -1], [0, 1, 0], [0, 1, 1]],
        tangent=[[1, 0, 0]] * 3,
        friction=[0.0] * 3,
        free_velocity=[0, -1, 0],
        bias=[0] * 3,
    )
    found = census(problem)
    assert (found.shape, found.velocity_shape) == (Shape.CONVEX, Shape.ONE)
    assert found.pieces[0].dimension == 1
    ends = sorted(found.pieces[0].vertices[:, 2])
    assert ends == pytest.approx([0, 1])
