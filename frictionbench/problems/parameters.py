"""Checks of the parameters of scenes and instances: every error names the parameter and its range."""

from typing import Any

import numpy as np

from frictionbench.problems.check import require

MOST = 10**8  # of whatever is counted: no machine holds a problem of more


def number(name: str, value: Any, above: float = -np.inf, least: float = -np.inf, most: float = np.inf) -> float:
    """A finite number with above < value, least <= value <= most. Errors: InputError naming the parameter."""
    real = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    require(real, name, f"expected a number, got {value!r}")
    limits = (
        [f"above {above:g}"] * (above > -np.inf)
        + [f"at least {least:g}"] * (least > -np.inf)
        + [f"at most {most:g}"] * (most < np.inf)
    )
    inside = np.isfinite(value) and above < value and least <= value <= most
    require(bool(inside), name, f"must be {' and '.join(['finite', *limits])}, got {value!r}")
    return float(value)


def count(name: str, value: Any, least: int = 1) -> int:
    """An integer from `least` to MOST. Errors: InputError naming the parameter."""
    require(isinstance(value, (int, np.integer)) and not isinstance(value, bool), name, f"expected an integer, got {value!r}")
    require(value >= least, name, f"must be at least {least}, got {value!r:.100}")
    require(value <= MOST, name, f"must be at most {MOST}, got {value!r:.100}")
    return int(value)
