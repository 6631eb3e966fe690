"""What the time-stepping schemes share.

A scheme takes a scene, the step before, and a way to solve friction problems, and returns the next step. It knows no solver:
`solve` maps a FrictionProblem to its impulses (nc, d). Every problem it had solved is kept in the step.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

from problems.check import Array
from problems.collision import Contacts
from problems.friction import FrictionProblem
from problems.scene import Scene

Solve = Callable[[FrictionProblem], Array]
Phase = Literal["compression", "decompression", "step"]


class Solved(NamedTuple):
    """A friction problem of one time step and the impulses (nc, d), N s, that the solver gave."""

    phase: Phase
    problem: FrictionProblem
    impulse: Array


@dataclass(frozen=True, eq=False)
class Step:
    """The state (q, v) at the time t that a step ends at, the contacts it used, and what it solved, in order."""

    time: float
    q: Array
    v: Array
    contacts: Contacts
    solved: tuple[Solved, ...] = ()


Scheme = Callable[[Scene, Step, Solve], Step]


def start(scene: Scene) -> Step:
    """The scene's initial state, as a step in which nothing was solved."""
    return Step(0.0, scene.q0, scene.v0, scene.contacts(scene.q0))


def respond(phase: Phase, problem: FrictionProblem, solve: Solve) -> tuple[Solved, Array]:
    """Solve a problem; the record of it, and the velocity (nv,) afterwards."""
    impulse = solve(problem)
    return Solved(phase, problem, impulse), problem.velocity(impulse)
