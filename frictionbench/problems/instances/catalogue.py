"""The catalogue of instances: friction problems of one step, made from parameters and a seed, that no scene simulates.

@instance
def cubes(boxes: int = 5, friction: float = 0.5, ...) -> FrictionProblem: ...
"""

from collections.abc import Callable
from typing import Any, TypeVar

from frictionbench.problems.catalogue import Catalogue, Generator
from frictionbench.problems.friction import FrictionProblem

CATALOGUE: Catalogue[FrictionProblem] = Catalogue("instance")
Function = TypeVar("Function", bound=Callable[..., FrictionProblem])


def instance(make: Function) -> Function:
    """List a generator of problems under its name. Errors: ValueError where the name is taken."""
    CATALOGUE.add(make)
    return make


def instances() -> dict[str, Generator[FrictionProblem]]:
    """All instances by name, in alphabetical order: a Generator each, with parameters (defaults) and summary.

    >>> import frictionbench as fb
    >>> fb.instances()["cubes"].parameters["friction"]
    0.5
    """
    return CATALOGUE.generators()


def make_instance(name: str, **parameters: Any) -> FrictionProblem:
    """The named problem, with the parameters given in place of its defaults.

    Errors: InputError naming the instance or parameter that is unknown, or the parameter that is out of range.

    >>> import frictionbench as fb
    >>> fb.instance("cubes", boxes=4, friction=0.3).dimension
    3
    """
    found = CATALOGUE.find(name, parameters)
    return found.make(**found.parameters | parameters)
