"""Scenes, the friction problem of one time step and its forms, and the schemes that step a scene through time."""

from problems.check import InputError
from problems.forms.lcp import LCP
from problems.friction import FrictionProblem
from problems.scenes import scene, scenes

__all__ = ["LCP", "FrictionProblem", "InputError", "scene", "scenes"]
