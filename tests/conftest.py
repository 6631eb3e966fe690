"""One thread for every library, as in a worker: on cores that are shared, threads that wait for one another cost tenfold.

To be said before numpy is imported; numba cannot change its mind once its threads have started either.
"""

import os

for library in ("OMP", "OPENBLAS", "MKL", "NUMBA", "RAYON"):
    os.environ[f"{library}_NUM_THREADS"] = "1"
