"""Time of nonsmooth Gauss-Seidel's sweeps."""

import numpy as np
import pytest

from frictionbench.problems.scenes import scene
from frictionbench.solvers.sweeps.form import contact_form
from tests.helpers.friction_problems import spatial
from tests.helpers.kernels import planar_sweeps, spatial_sweeps


@pytest.mark.parametrize("rows", [5, 30])
def test_planar_sweeps(benchmark, rows) -> None:
    form = contact_form(scene("pyramid", rows=rows).problem())
    r, x = np.zeros_like(form.offset), form.rest.copy()
    planar_sweeps(form, r, x, 1.0, 1)
    benchmark.extra_info["contact sweeps"] = 10 * len(r)
    benchmark(planar_sweeps, form, r, x, 1.0, 10)


def test_spatial_sweeps(benchmark) -> None:
    form = contact_form(spatial(0, contacts=100, nv=300))
    r, x = np.zeros_like(form.offset), form.rest.copy()
    spatial_sweeps(form, r, x, 1.0, 1)
    benchmark.extra_info["contact sweeps"] = 10 * len(r)
    benchmark(spatial_sweeps, form, r, x, 1.0, 10)
