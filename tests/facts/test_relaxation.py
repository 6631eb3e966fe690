"""The convex relaxation and the polygonal cone: what they answer, and the size of their errors."""

import numpy as np
import pytest

from frictionbench.problems.catalogue import make_instance
from frictionbench.problems.residual import relaxation_residual, residual_floor
from frictionbench.problems.verdicts import Verdict
from frictionbench.problems.verify import verify
from frictionbench.solvers import find, solve
from tests.helpers.friction_problems import block, contacts_of

G = 9.81


@pytest.mark.parametrize("spec", ["admm", "apgd", "clarabel", "osqp", "proxsuite", "relaxation_ip"])
@pytest.mark.parametrize("mu", [0.2, 0.6, 1.5])
def test_impact_of_a_sliding_block(mu, spec) -> None:
    """r_n = m (g h + mu v)/(1 + mu^2), u_t = (v - mu g h)/(1 + mu^2), u_n = mu u_t; Coulomb's u_n is 0."""
    m, h, v = 2.0, 0.01, 1.0
    problem = block(speed=v, friction=mu, mass=m, h=h)
    r = solve(problem, spec, tol=1e-10).impulse  # it may report failure where its gap is below its rounding
    assert relaxation_residual(problem, r) <= 1e-10 + residual_floor(problem, r)
    assert r[0, 0] == pytest.approx(m * (G * h + mu * v) / (1 + mu * mu))
    u_t = (v - mu * G * h) / (1 + mu * mu)
    assert problem.contact_velocity(r) == pytest.approx(np.array([[mu * u_t, u_t]]))
    exact = solve(problem, "lemke", tol=1e-10).impulse
    assert exact[0, 0] == pytest.approx(m * G * h)
    assert problem.contact_velocity(exact) == pytest.approx(np.array([[0, v - mu * G * h]]))


@pytest.mark.parametrize(("facets", "percent"), [(4, 29), (8, 7.6), (16, 1.9)])
def test_polygon_friction_deficit(facets, percent) -> None:
    """A particle sliding half-way between two of the polygon's corners; along a corner nothing is lost."""
    mu, deficits = 0.5, {}
    for name, angle in (("between", np.pi / facets), ("along", 2 * np.pi / facets)):
        way = np.array([np.cos(angle), np.sin(angle)])
        problem = contacts_of([[0, 0, 1]], [[1, 0, 0], [0, 1, 0]], [mu], [*(10 * way), -1])
        lcp = problem.lcp(facets=facets)
        answer = solve(lcp, "lemke", tol=1e-10)
        assert answer.z is not None
        r = lcp.impulse(answer.z)[0]
        assert r[0] == pytest.approx(1)
        deficits[name] = 1 + way @ r[1:] / mu
    assert deficits["along"] == pytest.approx(0, abs=1e-12)
    assert deficits["between"] == pytest.approx(1 - np.cos(np.pi / facets))
    assert 100 * deficits["between"] == pytest.approx(percent, abs=0.5 if facets == 4 else 0.05)


@pytest.mark.parametrize("name", ["lemke", "path_search", "dantzig", "fischer_newton", "minmap_newton", "murty"])
def test_polygon_error_is_model_error(name) -> None:
    problem = make_instance("cubes", boxes=1, friction=0.3, push=0.3)
    spec = f"{name}[facets=12]"
    finding = verify(problem, solve(problem, spec, tol=1e-8), find(spec)[0].model, 1e-8)
    if name != "murty":  # sure for P-matrices only, and this is none
        assert finding.verdict == Verdict.RELAXED
        assert finding.model_residual <= 1e-8
    assert finding.residual > 1e-5
