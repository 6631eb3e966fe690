"""The scenes by name.

    @generator(example_3={"friction": 0.02}, example_4={"friction": 0.1})
    def two_blocks(friction: float = 0.02, ...) -> Scene: ...

lists a function under its own name and under others with defaults of their own. Every scene also takes mass_unit and
length_unit, in which its masses and lengths are then counted: the same motion in other numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from inspect import getdoc, signature
from typing import Any, TypeVar

from frictionbench.problems.check import require
from frictionbench.problems.scene import Scene
from frictionbench.problems.scenes.parameters import number
from frictionbench.problems.scenes.units import in_units


@dataclass(frozen=True)
class SceneInfo:
    """A scene's name, its generator, the generator's parameters with their defaults, and what it says of itself."""

    name: str
    make: Callable[..., Scene]
    parameters: dict[str, Any]
    description: str

    @property
    def summary(self) -> str:
        return self.description.splitlines()[0]


UNITS = ("mass_unit", "length_unit")
_scenes: dict[str, SceneInfo] = {}
Generator = TypeVar("Generator", bound=Callable[..., Scene])


def generator(**others: dict[str, Any]) -> Callable[[Generator], Generator]:
    """List a scene's generator under its name, and under each name in `others` with the defaults given there."""

    def register(make: Generator) -> Generator:
        defaults = {key: parameter.default for key, parameter in signature(make).parameters.items()}
        for name, own in {make.__name__: {}, **others}.items():
            if name in _scenes:
                raise ValueError(f"scene: the name {name!r} is taken by {_scenes[name].make}")
            _scenes[name] = SceneInfo(name, make, defaults | own, getdoc(make) or "")
        return make

    return register


def scenes() -> dict[str, SceneInfo]:
    """All scenes by name, in alphabetical order: a SceneInfo each, with parameters (defaults) and summary.

    >>> import frictionbench as fb
    >>> "blocks" in fb.scenes()["stack"].parameters
    True
    """
    return dict(sorted(_scenes.items()))


def scene(name: str, **parameters: Any) -> Scene:
    """The named scene, with the parameters given in place of its defaults.

    Every scene also takes mass_unit (kg) and length_unit (m), units in which its masses and lengths are then counted.
    Scene.problem() gives the friction problem of its first time step.
    Errors: InputError naming the scene or parameter that is unknown, or the parameter that is out of range.

    >>> import frictionbench as fb
    >>> scene = fb.scene("stack", blocks=3, friction=0.5)
    >>> len(scene.bodies), scene.step, scene.problem().contacts
    (3, 0.01, 6)
    """
    require(name in _scenes, "scene", f"unknown scene {name!r}; known are {', '.join(scenes())}")
    info = _scenes[name]
    units = {key: number(key, parameters[key], above=0) for key in UNITS if key in parameters}
    for key in parameters.keys() - units:
        require(key in info.parameters, key, f"the scene {name} has no such parameter; it has {', '.join(info.parameters)}")
    chosen = info.parameters | parameters
    for key in {"friction", "restitution", "step", "duration"} & chosen.keys():
        number(key, chosen[key])
    made = info.make(**{key: value for key, value in chosen.items() if key not in units})
    if units:
        made = in_units(made, units.get("mass_unit", 1.0), units.get("length_unit", 1.0))
    return replace(made, name=name, parameters=chosen)
