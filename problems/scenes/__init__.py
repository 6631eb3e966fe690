"""The scenes by name.

    scene("stack", blocks=10, friction=0.5)        scene("example_2")

The talk's numbered examples (Anitescu 1999, page 30) are scenes of this list with the talk's friction and restitution.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from inspect import getdoc, signature
from typing import Any

from problems.check import require
from problems.scene import Scene
from problems.scenes.ball_and_bowl import bouncing_ball, bowl
from problems.scenes.between_walls import jam, wedge
from problems.scenes.blocks import three_blocks, two_blocks
from problems.scenes.long_bar import long_bar
from problems.scenes.mechanisms import pendulum, slider_crank
from problems.scenes.one_block import incline, rocking_block, two_corner_block
from problems.scenes.painleve_rod import painleve_rod
from problems.scenes.parameters import number
from problems.scenes.pens import multiple_collisions, several_blocks
from problems.scenes.redundant_table import redundant_table
from problems.scenes.stacks import pyramid, stack, wall
from problems.scenes.stopping_block import stopping_block

__all__ = ["SceneInfo", "scene", "scenes"]

_GENERATORS: dict[str, Callable[..., Scene]] = {
    "bouncing_ball": bouncing_ball,
    "bowl": bowl,
    "example_1": partial(long_bar, friction=0.05),
    "example_2": partial(long_bar, friction=0.2),
    "example_3": partial(two_blocks, friction=0.02),
    "example_4": partial(two_blocks, friction=0.1),
    "example_5": multiple_collisions,
    "example_6": partial(three_blocks, friction=0.05),
    "example_7": several_blocks,
    "incline": incline,
    "jam": jam,
    "long_bar": long_bar,
    "multiple_collisions": multiple_collisions,
    "painleve_rod": painleve_rod,
    "pendulum": pendulum,
    "pyramid": pyramid,
    "redundant_table": redundant_table,
    "rocking_block": rocking_block,
    "several_blocks": several_blocks,
    "slider_crank": slider_crank,
    "stack": stack,
    "stopping_block": stopping_block,
    "three_blocks": three_blocks,
    "two_blocks": two_blocks,
    "two_corner_block": two_corner_block,
    "wall": wall,
    "wedge": wedge,
}


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


def scenes() -> dict[str, SceneInfo]:
    """All scenes by name."""
    return {name: _describe(name, make) for name, make in _GENERATORS.items()}


def scene(name: str, **parameters: Any) -> Scene:
    """The named scene, with the parameters given in place of its defaults.

    Errors: InputError naming the scene or parameter that is unknown, or the parameter that is out of range.
    """
    require(name in _GENERATORS, "scene", f"unknown scene {name!r}; known are {', '.join(sorted(_GENERATORS))}")
    info = _describe(name, _GENERATORS[name])
    for key in parameters:
        require(key in info.parameters, key, f"the scene {name} has no such parameter; it has {', '.join(info.parameters)}")
    chosen = info.parameters | parameters
    for key in {"friction", "restitution", "step", "duration"} & chosen.keys():
        number(key, chosen[key])
    return replace(info.make(**chosen), name=name, parameters=chosen)


def _describe(name: str, make: Callable[..., Scene]) -> SceneInfo:
    defaults = {key: parameter.default for key, parameter in signature(make).parameters.items()}
    function = make.func if isinstance(make, partial) else make
    return SceneInfo(name, make, defaults, getdoc(function) or "")
