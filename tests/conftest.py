"""Settings of all tests: every numerical library runs on one thread, as in the workers of a run.

The environment variables must be set before numpy is imported and before numba starts its threads.
"""

import os
import sys

import pytest

for library in ("OMP", "OPENBLAS", "MKL", "NUMBA", "RAYON"):
    os.environ[f"{library}_NUM_THREADS"] = "1"


@pytest.fixture(scope="session", autouse=True)
def _end_processes():
    """End the worker server and the child processes of outside libraries that tests have started."""
    yield
    if (pool := sys.modules.get("frictionbench.harness.workers.pool")) and pool._server:
        pool._server.close()
    if children := sys.modules.get("frictionbench.solvers.outside.children.child"):
        for child in children._children.values():
            child.end()
