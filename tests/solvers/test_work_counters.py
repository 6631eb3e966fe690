"""Work counters equal independent counts of kernel calls, also of the solvers that a portfolio runs, which it names."""

import json
import os
import subprocess
import sys
from collections import defaultdict

import pytest

from frictionbench.solvers import available
from tests.helpers.paths import HELPERS, ROOT

# What each unit of a solver's work should be in calls of kernels; a check of the residual is a product.
UNITS = {
    "interior_point": {"factorisations": "sparse factorisations"},
    "relaxation_ip": {"factorisations": "sparse factorisations"},
    "proximal_newton": {"factorisations": "sparse factorisations"},
    "path_search": {"factorisations": "basis factorisations", "pivots": "basis exchanges"},
    **{name: {"pivots": "exchanges", "inversions": "inversions"} for name in ("lemke", "dantzig", "murty")},
    **{name: {"factorisations": "dense factorisations"} for name in ("fischer_newton", "minmap_newton")},
    **{name: {"sweeps": "sweeps", "checks": "products"} for name in ("nsgs", "nncg")},
    **{name: {"products": "products"} for name in ("apgd", "apgd_coulomb", "staggered", "anitescu_hart")},
    **{
        name: {"factorisations": "sparse factorisations", "iterations": "alternations", "checks": "products"}
        for name in ("admm", "admm_coulomb")
    },
}


@pytest.fixture(scope="module")
def counted():
    script = HELPERS / "counted_work.py"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False, env=environment, timeout=500)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_every_unit_of_work_is_counted(counted):
    seen = set()
    for name, work, calls in counted:
        own = name.partition("[")[0]
        expected = defaultdict(int)
        for unit, count in work.items():
            *inner, last = unit.split(" ")  # the member's name, innermost last, before the unit
            assert {*inner} & available().keys() <= {*available()[own].members}, (name, unit)
            expected[UNITS.get(inner[-1] if inner else own, {}).get(last, "")] += count
        expected.pop("", None)
        assert {kernel: count for kernel, count in expected.items() if count} == calls, (name, work)
        seen |= {own} if calls else set()
    assert seen == UNITS.keys() | {"hybrid"}
