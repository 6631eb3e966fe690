"""Painlevé's rod at the force and impulse levels: which problems have no, one, two or three solutions."""

import numpy as np
import pytest

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.analysis.mode import mode
from frictionbench.problems.analysis.polyhedra import Shape
from frictionbench.problems.catalogue import scene
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.solvers import solve
from tests.helpers.lcp_census import lcp_census

G = 9.81


def p(angle, mu) -> float:
    return 1 + 3 * np.cos(angle) ** 2 - 3 * mu * abs(np.sin(angle) * np.cos(angle))


def force_level(angle, mu, spin, speed=-1.0):
    """The rod's force-level LCP while it slides with the sign s: 0 <= f  ⟂  A f + K >= 0, of the normal acceleration.

    A = N M^-1 (N - s mu T)' is p, and K = N M^-1 k + sin(angle) spin^2: the tip rises at y' - cos(angle) spin. Where p > 0
    there is one solution, where p < 0 none for K < 0 and two for K > 0 (Painlevé 1895; Lötstedt 1981; Baraff 1993).
    """
    made = scene("painleve_rod", angle=angle, friction=mu, spin=spin, tip_velocity=speed)
    contacts = made.contacts(made.q0)
    k = made.force(made.q0, made.v0, 0.0)
    N, T = contacts.normal.toarray(), contacts.tangent.toarray()
    direction = N - np.sign(T @ made.v0) * mu * T
    return LCP(N / made.weights @ direction.T, N @ (k / made.weights) + np.sin(angle) * spin**2)


def impulse_level(angle, mu, spin, h=1e-4, speed=-1.0) -> FrictionProblem:
    """One step of the rod on its tip, with the normal's rate in the bias: the force-level problem times h while it slides."""
    made = scene("painleve_rod", angle=angle, friction=mu, spin=spin, tip_velocity=speed)
    contacts = made.contacts(made.q0)
    free = made.v0 + h * made.force(made.q0, made.v0, 0.0) / made.weights
    return made.friction_problem(made.q0, free, contacts, bias=h * np.sin(angle) * spin**2)


STEEP = np.arctan(2.0)


@pytest.mark.parametrize(
    ("mu", "spin", "forces", "modes"),
    [(0.3, 0.0, 1, {"l"}), (0.3, 5.0, 1, {"o"}), (1.6, 0.0, 0, {"s"}), (1.6, 5.0, 2, {"o", "l", "s"})],
)
def test_the_four_regimes(mu, spin, forces, modes) -> None:
    """K = spin^2 sin(angle) - g. Forces: one, one, none, two. Impulses: one, one, only the stick, three."""
    lcp = force_level(STEEP, mu, spin)
    K = spin**2 * np.sin(STEEP) - G
    assert lcp.q == pytest.approx([K])
    assert lcp_census(lcp).count == forces
    h = 1e-4
    found = census(impulse_level(STEEP, mu, spin, h))
    assert {piece.mode for piece in found.pieces} == modes
    assert found.count == len(modes)
    by_mode = {piece.mode: piece.vertices[0] for piece in found.pieces}
    if "l" in by_mode:
        assert by_mode["l"] == pytest.approx(-h * K / p(STEEP, mu) * np.array([1, mu]))
    if modes == {"o", "l", "s"}:
        assert found.shape is Shape.ISOLATED
        assert by_mode["o"] == pytest.approx([0, 0])


@pytest.mark.parametrize(("angle", "mu", "spin"), [(STEEP, 1.6, 0.0), (1.0, 1.6, 0.0), (STEEP, 2.0, 5.0)])
def test_sticking_impulse_is_independent_of_step(angle, mu, spin) -> None:
    """r_n = 3/4 m sin cos |v_t|, r_t = 1/4 m (1 + 3 cos^2) |v_t|, losing m (1 + 3 cos^2) v_t^2/8 of energy."""
    assert p(angle, mu) < 0
    problem = impulse_level(angle, mu, spin, h=1e-9)
    (r,) = (piece.vertices for piece in census(problem).pieces if piece.mode == "s")
    s, c = np.sin(angle), np.cos(angle)
    assert r[0] == pytest.approx([0.75 * s * c, 0.25 * (1 + 3 * c * c)], abs=1e-6)
    free, v = problem.free_velocity, problem.velocity(r.reshape(1, 2))
    loss = (free @ (problem.mass @ free) - v @ (problem.mass @ v)) / 2
    assert loss == pytest.approx((1 + 3 * c * c) / 8, abs=1e-6)


@pytest.mark.parametrize(("spec", "letter"), [("lemke", "o"), ("nsgs", "o"), ("clarabel", "s")])
def test_solution_returned_by_each_solver(spec, letter) -> None:
    """From r = 0 all but one row of the LCP are right, and Lemke's path mends it by the sliding speed alone: the rod opens,
    as under Gauss-Seidel, for which r = 0 is a fixed point. The relaxation has one answer and that is the stick."""
    for problem in (impulse_level(STEEP, 1.6, 5.0), impulse_level(1.2, 3.0, 4.0, h=1e-2)):
        assert census(problem).count == 3
        answer = solve(problem, spec, tol=1e-10)
        assert min(residual(problem, answer.impulse), relaxation_residual(problem, answer.impulse)) <= 1e-10
        assert mode(problem, answer.impulse) == letter
