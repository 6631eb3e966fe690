"""One thread for every library, as in a worker: on cores that are shared, threads that wait for one another cost tenfold.

To be said before numpy is imported; numba cannot change its mind once its threads have started either.
"""

import os
import sys

import pytest

for library in ("OMP", "OPENBLAS", "MKL", "NUMBA", "RAYON"):
    os.environ[f"{library}_NUM_THREADS"] = "1"


@pytest.fixture(scope="session", autouse=True)
def _processes_end():
    """The server of workers and the libraries in child processes, where tests have started any, end with them."""
    yield
    if (pool := sys.modules.get("frictionbench.harness.workers.pool")) and pool._server:
        pool._server.close()
    if children := sys.modules.get("frictionbench.solvers.outside.children.child"):
        for child in children._children.values():
            child.end()
