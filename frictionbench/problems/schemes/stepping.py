"""The interface of the time-stepping schemes, and the functions that they share.

A scheme takes a scene, the previous step and a function `solve`, and returns the next step. `solve` maps a FrictionProblem to
its impulses (nc, d), so that a scheme does not depend on a solver. The step records every problem that was solved.

    @scheme("lotstedt", lacks=("restitution",))
    def lotstedt(scene, now, solve): ...

A scheme states in advance which scenes it does not support (`refuses`). It raises NoSolution if its equations have no solution,
which is a property of the scheme and not a failure of the solver.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

from frictionbench.problems.catalogue import near
from frictionbench.problems.check import Array, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene

Solve = Callable[[FrictionProblem], Array]
Phase = Literal["compression", "decompression", "impact", "forces", "step"]
Feature = Literal["friction", "restitution"]


class NoSolution(Exception):  # noqa: N818  # a finding, not an error
    """The scheme's equations have no solution at this step; the message says at which contact and when."""


class Solved(NamedTuple):
    """A friction problem of one time step, the solver's impulses (nc, d), N s, and the contacts. In the phase `forces`, the
    problem is in accelerations and forces, N. returned: (nc,), the normal impulses that Poisson's law returns before a
    decompression."""

    phase: Phase
    problem: FrictionProblem
    impulse: Array
    contacts: Contacts
    returned: Array | float = 0.0


class Smooth(NamedTuple):
    """Smooth motion within a step: the closed contacts, their impulses (nc, 2), N s, the work of friction, J, and the number
    of evaluations of the forces."""

    contacts: Contacts
    impulse: Array
    work: float
    evaluations: int


class Event(NamedTuple):
    """A located event within a step: its time, kind and the velocities (nv,) before and after."""

    time: float
    kind: str
    before: Array
    after: Array


@dataclass(frozen=True, eq=False)
class Step:
    """The state (q, v) at the end of a step, with its time, its contacts and the problems solved, in order. An event-driven
    scheme also records the smooth parts and the events of the step."""

    time: float
    q: Array
    v: Array
    contacts: Contacts
    solved: tuple[Solved, ...] = ()
    smooth: tuple[Smooth, ...] = ()
    events: tuple[Event, ...] = ()


@dataclass(frozen=True)
class Scheme:
    """advance: one step of length scene.step. lacks: properties of scenes that it does not support. events: whether it is
    event-driven within a step, which requires a solver that is exact up to rounding."""

    advance: Callable[[Scene, Step, Solve], Step]
    lacks: tuple[Feature, ...] = ()
    events: bool = False

    def refuses(self, scene: Scene) -> str | None:
        """The reason why this scheme does not support the scene, or None."""
        if self.events and scene.dimension != 2:
            return "it follows planar motion only: in space a contact slides in directions that change all the time"
        unmet = [feature for feature in self.lacks if getattr(scene, feature) > 0]
        return f"it has no law of {' and '.join(unmet)}" if unmet else None

    def __call__(self, scene: Scene, now: Step, solve: Solve) -> Step:
        """The step after `now`. Errors: InputError if the scheme refuses the scene, NoSolution."""
        reason = self.refuses(scene)
        require(reason is None, "scheme", str(reason))
        return self.advance(scene, now, solve)


SCHEMES: dict[str, Scheme] = {}


def scheme(
    name: str, lacks: tuple[Feature, ...] = (), events: bool = False
) -> Callable[[Callable[[Scene, Step, Solve], Step]], Scheme]:
    """A decorator that makes a function a Scheme and registers it under `name`."""

    def register(advance: Callable[[Scene, Step, Solve], Step]) -> Scheme:
        SCHEMES[name] = Scheme(advance, lacks, events)
        return SCHEMES[name]

    return register


def require_scheme(name: str) -> None:
    """Errors: InputError if no scheme has this name."""
    require(name in SCHEMES, "scheme", f"unknown scheme {name!r}{near(name, SCHEMES)}; known are {', '.join(SCHEMES)}")


def start(scene: Scene) -> Step:
    """The scene's initial state, as a step in which nothing was solved."""
    return Step(0.0, scene.q0, scene.v0, scene.contacts(scene.q0))


def respond(phase: Phase, problem: FrictionProblem, contacts: Contacts, solve: Solve) -> tuple[Solved, Array]:
    """The solved problem, and the velocity (nv,) after its impulses."""
    impulse = solve(problem)
    return Solved(phase, problem, impulse, contacts), problem.velocity(impulse)


def free_velocity(scene: Scene, now: Step, v: Array) -> Array:
    """v + h M^-1 k (nv,): the velocity after a step without contacts and joints."""
    return v + scene.step * scene.accelerate(now.q, scene.force(now.q, v, now.time))


def contacts_within_reach(scene: Scene, q: Array, *velocities: Array) -> Contacts:
    """The contacts that could close within one step: their gaps are at most twice the way of the fastest point."""
    speed = max(scene.fastest(v) for v in velocities)
    return scene.contacts(q, scene.touch + 2 * scene.step * speed)
