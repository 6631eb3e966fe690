"""Paths inside the checkout, and motions that are stored there."""

from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
HELPERS = ROOT / "tests" / "helpers"
DATA = ROOT / "tests" / "data"  # regression problems
BAD_SOLVERS = HELPERS / "bad_solvers.py"


def siconos_motion(name: str) -> np.ndarray:
    """The rows of tests/data/siconos_NAME.csv, with the fields of its first line.

    Computed by Siconos and thinned: siconos/siconos-tutorials at b6c9bfd, examples/mechanics, Apache-2.0.
    """
    return np.genfromtxt(DATA / f"siconos_{name}.csv", delimiter=",", names=True)
