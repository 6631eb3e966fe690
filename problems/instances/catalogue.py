"""Friction problems of one step by name, made from a few parameters and a seed, without a scene that could move.

@instance
def cubes(boxes: int = 5, friction: float = 0.5, ...) -> FrictionProblem: ...
"""

from collections.abc import Callable
from dataclasses import dataclass
from inspect import getdoc, signature
from typing import Any, TypeVar

from frictionbench.problems.check import require
from frictionbench.problems.friction import FrictionProblem


@dataclass(frozen=True)
class InstanceInfo:
    """An instance's name, what makes it, its parameters with their defaults, and what it says of itself."""

    name: str
    make: Callable[..., FrictionProblem]
    parameters: dict[str, Any]
    description: str

    @property
    def summary(self) -> str:
        return self.description.splitlines()[0]


_instances: dict[str, InstanceInfo] = {}
Maker = TypeVar("Maker", bound=Callable[..., FrictionProblem])


def instance(make: Maker) -> Maker:
    """List a maker of problems under its name."""
    name = make.__name__
    if name in _instances:
        raise ValueError(f"instance: the name {name!r} is taken by {_instances[name].make}")
    defaults = {key: parameter.default for key, parameter in signature(make).parameters.items()}
    _instances[name] = InstanceInfo(name, make, defaults, getdoc(make) or "")
    return make


def instances() -> dict[str, InstanceInfo]:
    """All instances by name, in alphabetical order: an InstanceInfo each, with parameters (defaults) and summary.

    >>> import frictionbench as fb
    >>> fb.instances()["cubes"].parameters["friction"]
    0.5
    """
    return dict(sorted(_instances.items()))


def make_instance(name: str, **parameters: Any) -> FrictionProblem:
    """The named problem, with the parameters given in place of its defaults.

    Errors: InputError naming the instance or parameter that is unknown, or the parameter that is out of range.

    >>> import frictionbench as fb
    >>> fb.instance("cubes", boxes=4, friction=0.3).dimension
    3
    """
    require(name in _instances, "instance", f"unknown instance {name!r}; known are {', '.join(instances())}")
    info = _instances[name]
    for key in parameters:
        require(key in info.parameters, key, f"{name} has no such parameter; it has {', '.join(info.parameters)}")
    return info.make(**info.parameters | parameters)
