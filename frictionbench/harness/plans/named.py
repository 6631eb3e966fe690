"""Scenes and instances by name, as plans and commands write them."""

from typing import Any

from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.instances import CATALOGUE, instances, make_instance
from frictionbench.problems.scenes.catalogue import find_scene


def require_known(name: str, settings: dict[str, Any]) -> None:
    """Errors: InputError naming the scene or instance, or the setting, that is unknown; nothing is built."""
    if name in instances():
        CATALOGUE.find(name, settings)
    else:
        find_scene(name, settings)


def problem_of(name: str, settings: dict[str, Any]) -> FrictionProblem:
    """The instance, or the problem of the scene at its start. Errors: InputError as for require_known, or of a setting."""
    return make_instance(name, **settings) if name in instances() else scene(name, **settings).problem()
