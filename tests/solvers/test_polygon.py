"""LCP solvers in space: the polygon's model error is separate from the solver's and decreases with the facets."""

from itertools import pairwise

import numpy as np
import pytest

from frictionbench.harness.plans.choose import choose
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.problems import InputError
from frictionbench.problems.instances import make_instance
from frictionbench.problems.verdicts import Verdict
from frictionbench.problems.verify import verify
from frictionbench.results.extras import POLYGON, read_deviations
from frictionbench.results.files import ResultsError
from frictionbench.solvers import find, solve

LCP_SOLVERS = ("lemke", "path_search", "dantzig", "fischer_newton", "minmap_newton", "murty")


def sliding():
    return make_instance("cubes", boxes=1, friction=0.3, push=0.3)


@pytest.mark.parametrize("name", LCP_SOLVERS)
def test_polygon_error_is_model_error(name) -> None:
    problem = sliding()
    spec = f"{name}[facets=12]"
    finding = verify(problem, solve(problem, spec, tol=1e-8), find(spec)[0].model, 1e-8)
    if name != "murty":  # sure for P-matrices only, and this is none
        assert finding.verdict == Verdict.RELAXED
        assert finding.model_residual <= 1e-8
    assert finding.residual > 1e-5


def test_error_decreases_with_facets() -> None:
    """The polygon's corner that is nearest to the direction of sliding is the farther from it the fewer there are."""
    problem = sliding()
    sizes = (4, 8, 16, 32, 64)
    errors = [verify(problem, solve(problem, f"lemke[facets={k}]"), "lcp", 1e-8).residual for k in sizes]
    assert all(later <= earlier * (1 + 1e-9) for earlier, later in pairwise(errors))
    assert errors[-1] < errors[0] / 8
    assert solve(problem, "lemke[facets=64]").z.size == 4 * 66


@pytest.mark.parametrize("facets", [2, 3, 7, -8])
def test_facets_are_even_and_at_least_four(facets) -> None:
    with pytest.raises(InputError, match=r"^facets: "):
        solve(sliding(), f"lemke[facets={facets}]")


def test_facets_are_ignored_in_plane() -> None:
    problem = make_instance("random", seed=1, contacts=3)
    assert np.array_equal(solve(problem, "lemke[facets=16]").impulse, solve(problem, "lemke").impulse)


def test_run_writes_polygon_deviations(tmp_path) -> None:
    plan = choose("spatial", ["cubes[boxes=1]"], ("lemke[facets=16]",), "1e-8", 5.0)
    run(plan, tmp_path, 1, Progress())
    circle, *polygons = read_deviations(tmp_path)
    assert circle.from_parabola < 1e-3
    assert [row.facets for row in polygons] == [4, 6, 8, 16, 32, 64]
    doubled = [row for row in polygons if row.facets != 6]  # a hexagon may happen to have a corner along the path
    assert all(later.from_cone < earlier.from_cone for earlier, later in pairwise(doubled))
    (tmp_path / POLYGON).write_text('[{"facets": 4}]', encoding="utf-8")
    with pytest.raises(ResultsError, match=r"polygon\.json: cannot be read"):
        read_deviations(tmp_path)
