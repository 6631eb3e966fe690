"""Motions computed by Siconos, thinned: siconos/siconos-tutorials at b6c9bfd, examples/mechanics, Apache-2.0."""

import numpy as np

from tests.helpers.paths import DATA


def siconos_motion(name: str) -> np.ndarray:
    """The rows of tests/data/siconos_NAME.csv, with the fields of its first line."""
    return np.genfromtxt(DATA / f"siconos_{name}.csv", delimiter=",", names=True)
