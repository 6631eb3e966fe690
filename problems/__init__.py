"""Scenes, the friction problem of one time step and its forms, and the schemes that step a scene through time."""

from problems.compiled import keep_compiled

keep_compiled()  # before the first kernel is declared

from problems.check import InputError  # noqa: E402
from problems.forms.lcp import LCP  # noqa: E402
from problems.friction import FrictionProblem  # noqa: E402
from problems.scenes import scene, scenes  # noqa: E402

__all__ = ["LCP", "FrictionProblem", "InputError", "scene", "scenes"]
