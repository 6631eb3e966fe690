"""CPU seconds to a solver's first answer from nothing: no kernel compiled before, the problem met for the first time too."""

import os
import subprocess
import sys

import pytest

FIRST = """
from time import process_time
from frictionbench.problems.scenes import scene
from frictionbench.solvers import solve
begun = process_time()
problem = scene("stack", blocks=3, push=1.0).problem()
met = process_time()
for spec in {specs}:
    solve(problem.fresh(), spec)
print(met - begun, process_time() - met)
"""
OURS = ["nsgs", "lemke", "path_search", "interior_point", "relaxation_ip", "hybrid"]


@pytest.mark.parametrize("specs", [[spec] for spec in OURS] + [OURS], ids=[*OURS, "all"])
def test_first_answer(benchmark, specs, tmp_path) -> None:
    command = [sys.executable, "-c", FIRST.format(specs=specs)]
    settings = dict(os.environ, NUMBA_CACHE_DIR=str(tmp_path), PYTHONPATH=os.getcwd())
    done = benchmark.pedantic(subprocess.run, (command,), {"env": settings, "capture_output": True, "text": True}, rounds=1)
    benchmark.extra_info["CPU s: problem, answer"] = [float(seconds) for seconds in done.stdout.split()]
    assert done.returncode == 0, done.stderr
