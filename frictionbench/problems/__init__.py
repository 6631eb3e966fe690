"""Scenes, the friction problem of one time step and its forms, and the schemes that step a scene through time."""

from frictionbench.problems.compiled import set_kernel_cache

set_kernel_cache()  # before the first kernel is declared

from frictionbench.problems.check import InputError  # noqa: E402
from frictionbench.problems.forms.lcp import LCP  # noqa: E402
from frictionbench.problems.friction import FrictionProblem  # noqa: E402
from frictionbench.problems.scenes import scene, scenes  # noqa: E402

__all__ = ["LCP", "FrictionProblem", "InputError", "scene", "scenes"]
