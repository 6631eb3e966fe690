"""LCP solvers in space: the polygon's model error is separate from the solver's and decreases with the facets."""

import pytest

from frictionbench.problems.catalogue import make_instance
from frictionbench.problems.verdicts import Verdict
from frictionbench.problems.verify import verify
from frictionbench.solvers import find, solve

LCP_SOLVERS = ("lemke", "path_search", "dantzig", "fischer_newton", "minmap_newton", "murty")


@pytest.mark.parametrize("name", LCP_SOLVERS)
def test_polygon_error_is_model_error(name) -> None:
    problem = make_instance("cubes", boxes=1, friction=0.3, push=0.3)
    spec = f"{name}[facets=12]"
    finding = verify(problem, solve(problem, spec, tol=1e-8), find(spec)[0].model, 1e-8)
    if name != "murty":  # sure for P-matrices only, and this is none
        assert finding.verdict == Verdict.RELAXED
        assert finding.model_residual <= 1e-8
    assert finding.residual > 1e-5
