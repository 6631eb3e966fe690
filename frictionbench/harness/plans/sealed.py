"""The problems of the suite `sealed`: the families of `standard`, with settings that nobody has chosen.

They are drawn from a hash of the source of all problems and solvers of this version, so that they exist once these are written
and others take their place when a line of them changes: no method can have been tuned on them. A count or a number that a
family of problems is given, and its friction, is multiplied by a factor between 1/SPREAD and SPREAD, uniform in its logarithm,
so that the regime, what sticks and what slides, is mostly kept; a seed is drawn anew. Whoever changes a comment until the draw
suits is not kept from it; each draw is kept by the version whose commit holds the source.
"""

from collections.abc import Iterable
from dataclasses import replace
from hashlib import sha256
from typing import Any

import numpy as np

from frictionbench.harness import machine
from frictionbench.harness.plans.plan import Source
from frictionbench.problems.catalogue import instances, scenes

SPREAD = 1.25
DIGITS = 3  # of what is drawn, so that names of problems can be read


def sealed(sources: Iterable[Source], digest: str | None = None) -> tuple[Source, ...]:
    """These sources with settings drawn from a digest, by default that of the source of this version's problems and solvers."""
    digest = digest or machine.content(("problems", "solvers"))
    return tuple(replace(source, parameters=_drawn(source, f"{digest} {k}")) for k, source in enumerate(sources))


def _drawn(source: Source, name: str) -> dict[str, Any]:
    draw = np.random.default_rng(list(sha256(name.encode()).digest()))
    defaults = (scenes() | instances())[source.scene].parameters
    given = {key: defaults[key] for key in ("seed", "friction") if defaults.get(key) is not None} | source.parameters
    factors = {key: SPREAD ** draw.uniform(-1, 1) for key in sorted(given)}
    drawn = {key: _scaled(value, factors[key]) for key, value in given.items()}
    return drawn | ({"seed": int(draw.integers(10**6))} if "seed" in drawn else {})


def _scaled(value: float, factor: float) -> float:
    return max(1, round(value * factor)) if isinstance(value, int) else float(f"{value * factor:.{DIGITS}g}")
