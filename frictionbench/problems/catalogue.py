"""The catalogues of scenes and of instances, each built from a name and a few parameters.

    @generator(friction=0.02, restitution=0.2, example_3={"friction": 0.02}, example_4={"friction": 0.1})
    def two_blocks(speed: float = 3.0) -> Scene: ...

    @instance()
    def cubes(boxes: int = 5, friction: float = 0.5, ...) -> FrictionProblem: ...

A scene is simulated over time. Its generator makes the bodies and the initial state; the fields LAWS of the scene are set here.
An instance is the friction problem of a single step, made from parameters and a seed and not by a scene.
Every scene also takes mass_unit and length_unit, the units in which its masses and lengths are given; they do not change the
motion.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from inspect import getdoc, signature
from pkgutil import iter_modules
from typing import Any, Generic, TypeVar

from frictionbench.problems.check import InputError, number, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.scene import Scene

UNITS = ("mass_unit", "length_unit")
LAWS = ("friction", "restitution", "step", "duration")
Made = TypeVar("Made")
SceneFunction = TypeVar("SceneFunction", bound=Callable[..., Scene])
InstanceFunction = TypeVar("InstanceFunction", bound=Callable[..., FrictionProblem])


def near(name: str, known: Iterable[str]) -> str:
    """The end of an error about an unknown name, such as " (did you mean lemke?)"; "" if no known name is similar."""
    matches = get_close_matches(name, list(known), n=1)
    return f" (did you mean {matches[0]}?)" if matches else ""


def import_all(package: str, path: list[str]) -> None:
    """Import every module of a package, whose decorators then register what they define; path: the package's __path__."""
    for module in iter_modules(path):
        import_module(f"{package}.{module.name}")


@dataclass(frozen=True)
class Generator(Generic[Made]):
    """A function in a catalogue, with its name, its parameters' defaults and its docstring. kind: "scene" or "instance".
    dimension: of the contacts in what it makes, 2 or 3, so that it is known before anything is made."""

    name: str
    make: Callable[..., Made]
    parameters: dict[str, Any]
    description: str
    dimension: int
    kind: str

    @property
    def summary(self) -> str:
        """The first paragraph of the description; empty under python -OO, which removes docstrings."""
        return " ".join(self.description.partition("\n\n")[0].split())


_REGISTERED: dict[str, Generator[Any]] = {}


@cache
def _all(kind: str) -> dict[str, Generator[Any]]:
    """All generators of a kind by name, in alphabetical order; the modules that register them are imported here."""
    package = f"frictionbench.problems.{kind}s"
    import_all(package, list(import_module(package).__path__))
    return {name: generator for name, generator in sorted(_REGISTERED.items()) if generator.kind == kind}


def _add(kind: str, make: Callable[..., Any], name: str, dimension: int, **defaults: Any) -> None:
    """List a function under a name; defaults replace those of its signature. Errors: ValueError if the name is taken."""
    if name in _REGISTERED:
        raise ValueError(f"{kind}: the name {name!r} is taken by {_REGISTERED[name].make}")
    parameters = {key: parameter.default for key, parameter in signature(make).parameters.items()}
    _REGISTERED[name] = Generator(name, make, parameters | defaults, getdoc(make) or "", dimension, kind)
    _all.cache_clear()


def _find(kind: str, name: str, parameters: Iterable[str]) -> Generator[Any]:
    """The generator of this kind and name. Errors: InputError naming the kind, or a parameter that the generator lacks."""
    require(isinstance(name, str), kind, f"expected its name as text, got {name!r:.100}")
    known = scenes() | instances()
    if name not in known:
        like = near(name.partition("[")[0], known) + "; its settings are further arguments" * ("[" in name)
        raise InputError(f"{kind}: unknown {kind} {name!r}{like}; `frictionbench list scenes` names all")
    generator = known[name]
    other = f"{name!r} is no {kind} but one problem; use `frictionbench solve` or frictionbench.problem"
    require(generator.kind == kind, kind, other)
    for key in set(parameters) - generator.parameters.keys() - {*(UNITS if kind == "scene" else ())}:
        like, its = near(key, generator.parameters), ", ".join(generator.parameters)
        raise InputError(f"{key}: the {kind} {name} has no such parameter{like}; it has {its}")
    return generator


def generator(
    dimension: int = 2,
    *,
    friction: float | None = None,
    restitution: float | None = None,
    step: float = 0.01,
    duration: float | None = None,
    **others: dict[str, Any],
) -> Callable[[SceneFunction], SceneFunction]:
    """List a scene's generator under its name, and under each name in `others` with the defaults given there.

    dimension: of its scenes, so that it is known before one is built. friction, restitution, step (s), duration (s): defaults
    of these parameters, which the function itself need not take; None if the scene has no such parameter.
    Errors: ValueError if a name is taken.
    """
    pairs = zip(LAWS, (friction, restitution, step, duration), strict=True)
    laws = {name: default for name, default in pairs if default is not None}

    def register(make: SceneFunction) -> SceneFunction:
        for name, defaults in {make.__name__: {}, **others}.items():
            _add("scene", make, name, dimension, **laws | defaults)
        return make

    return register


def instance(dimension: int = 3, name: str = "") -> Callable[[InstanceFunction], InstanceFunction]:
    """List a generator of problems with contacts of this dimension, under its own name or another.

    Errors: ValueError if the name is taken.
    """

    def register(make: InstanceFunction) -> InstanceFunction:
        _add("instance", make, name or make.__name__, dimension)
        return make

    return register


def scenes() -> dict[str, Generator[Scene]]:
    """All scenes by name, in alphabetical order: a Generator each, with parameters (defaults) and summary.

    >>> import frictionbench as fb
    >>> "blocks" in fb.scenes()["stack"].parameters
    True
    """
    return _all("scene")


def instances() -> dict[str, Generator[FrictionProblem]]:
    """All instances by name, in alphabetical order: a Generator each, with parameters (defaults) and summary.

    >>> import frictionbench as fb
    >>> fb.instances()["cubes"].parameters["friction"]
    0.5
    """
    return _all("instance")


def is_spatial(name: str) -> bool:
    """Whether this is the name of a scene or an instance in space."""
    return any(name in kind and kind[name].dimension == 3 for kind in (scenes(), instances()))


def find_scene(name: str, parameters: Iterable[str]) -> Generator[Scene]:
    """The generator of the named scene. Errors: InputError naming the scene or the parameter that is unknown."""
    return _find("scene", name, parameters)


def scene(name: str, **parameters: Any) -> Scene:
    """The named scene, with the parameters given in place of its defaults.

    Every scene also takes mass_unit (kg) and length_unit (m), the units in which its masses and lengths are given.
    Scene.problem() gives the friction problem of its first time step.
    Errors: InputError naming the scene or parameter that is unknown, or the parameter that is out of range.

    >>> import frictionbench as fb
    >>> scene = fb.scene("stack", blocks=3, friction=0.5)
    >>> len(scene.bodies), scene.step, scene.problem().contacts
    (3, 0.01, 6)
    """
    units = {key: number(key, parameters[key], above=0) for key in UNITS if key in parameters}
    generator = find_scene(name, parameters)
    chosen = generator.parameters | parameters
    laws: dict[str, Any] = {key: number(key, chosen[key]) for key in LAWS if key in chosen}
    made = generator.make(**{key: chosen[key] for key in signature(generator.make).parameters})
    if units:
        made = made.in_units(units.get("mass_unit", 1.0), units.get("length_unit", 1.0))
    return replace(made, name=name, parameters=chosen, **laws)


def make_instance(name: str, **parameters: Any) -> FrictionProblem:
    """The named problem, with the parameters given in place of its defaults.

    Errors: InputError naming the instance or parameter that is unknown, or the parameter that is out of range.

    >>> import frictionbench as fb
    >>> fb.instance("cubes", boxes=4, friction=0.3).dimension
    3
    """
    generator = _find("instance", name, parameters)
    return generator.make(**generator.parameters | parameters)


def require_known(name: str, parameters: Iterable[str]) -> None:
    """Check the names without building anything. Errors: InputError naming the unknown scene, instance or parameter."""
    _find("instance" if name in instances() else "scene", name, parameters)


def problem_of(name: str, **parameters: Any) -> FrictionProblem:
    """The named instance, or the problem of the named scene's first step, which `frictionbench solve NAME` solves.

    Errors: as for scene and instance.

    >>> import frictionbench as fb
    >>> fb.problem("stack", blocks=3).contacts, fb.problem("cubes", boxes=3).contacts
    (6, 12)
    """
    return make_instance(name, **parameters) if name in instances() else scene(name, **parameters).problem()
