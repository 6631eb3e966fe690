"""The child process of a fake library, which misbehaves as the message asks; used by tests/helpers/fake_libraries.py."""

import os
import subprocess
import sys
import time

import numpy as np
from child import serve


def answer(do, n=0):
    if do == "abort":
        os.abort()
    if do == "exit":
        os._exit(0)
    if do == "hang":
        while True:
            np.linalg.svd(np.random.default_rng(0).standard_normal((2000, 2000)))  # seconds each, in native code
    if do == "child":
        subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)", "orphan of a fake library"])
    if do == "print":
        print("x" * 10_000_000)
        os.write(1, b"y" * 10_000_000)
    if do == "big":
        return {"r": np.ones(2**24)[:n] * 0, "clock": 0.0}
    if do == "slow":
        time.sleep(0.2)
    return {"r": np.zeros(n), "clock": 1e-3}


serve(answer)
