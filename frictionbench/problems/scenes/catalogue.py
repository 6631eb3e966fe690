"""The catalogue of scenes.

    @generator(example_3={"friction": 0.02}, example_4={"friction": 0.1})
    def two_blocks(friction: float = 0.02, ...) -> Scene: ...

registers a function under its own name and under others with other defaults, @generator(dimension=3) one of scenes in space.
Every scene also takes mass_unit and length_unit,
the units in which its masses and lengths are then given: the motion is the same.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, TypeVar

from frictionbench.problems.catalogue import Catalogue, Generator
from frictionbench.problems.parameters import number
from frictionbench.problems.scene import Scene
from frictionbench.problems.scenes.units import in_units

UNITS = ("mass_unit", "length_unit")
CATALOGUE: Catalogue[Scene] = Catalogue("scene")
SPATIAL: set[str] = set()  # the names of scenes in space
Function = TypeVar("Function", bound=Callable[..., Scene])


def generator(dimension: int = 2, **others: dict[str, Any]) -> Callable[[Function], Function]:
    """List a scene's generator under its name, and under each name in `others` with the defaults given there.

    dimension: of its scenes, so that it is known before one is built. Errors: ValueError where a name is taken.
    """

    def register(make: Function) -> Function:
        for name, defaults in {make.__name__: {}, **others}.items():
            CATALOGUE.add(make, name, **defaults)
            if dimension == 3:
                SPATIAL.add(name)
        return make

    return register


def scenes() -> dict[str, Generator[Scene]]:
    """All scenes by name, in alphabetical order: a Generator each, with parameters (defaults) and summary.

    >>> import frictionbench as fb
    >>> "blocks" in fb.scenes()["stack"].parameters
    True
    """
    return CATALOGUE.generators()


def find_scene(name: str, parameters: Iterable[str]) -> Generator[Scene]:
    """The generator of the named scene. Errors: InputError naming the scene or the parameter that is unknown."""
    return CATALOGUE.find(name, [key for key in parameters if key not in UNITS])


def scene(name: str, **parameters: Any) -> Scene:
    """The named scene, with the parameters given in place of its defaults.

    Every scene also takes mass_unit (kg) and length_unit (m), the units in which its masses and lengths are then given.
    Scene.problem() gives the friction problem of its first time step.
    Errors: InputError naming the scene or parameter that is unknown, or the parameter that is out of range.

    >>> import frictionbench as fb
    >>> scene = fb.scene("stack", blocks=3, friction=0.5)
    >>> len(scene.bodies), scene.step, scene.problem().contacts
    (3, 0.01, 6)
    """
    units = {key: number(key, parameters[key], above=0) for key in UNITS if key in parameters}
    found = find_scene(name, parameters)
    chosen = found.parameters | parameters
    for key in {"friction", "restitution", "step", "duration"} & chosen.keys():
        number(key, chosen[key])
    made = found.make(**{key: value for key, value in chosen.items() if key not in units})
    if units:
        made = in_units(made, units.get("mass_unit", 1.0), units.get("length_unit", 1.0))
    return replace(made, name=name, parameters=chosen)
