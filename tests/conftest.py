"""One thread for every library, as in a worker: numba cannot change its mind once its threads have started."""

import os

os.environ["NUMBA_NUM_THREADS"] = "1"
