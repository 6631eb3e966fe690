"""The interface between phenomena and engines."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.81  # m/s^2


def gravity(slope: float) -> Array:
    """Return gravity (3,), m/s^2, turned by an angle from -z towards x."""
    return GRAVITY * np.array([np.sin(slope), 0.0, -np.cos(slope)])


class Body(NamedTuple):
    """A box of half sizes (3,), or a ball of one radius, in m; mass in kg.

    position (3,), velocity (3,), spin (3,) in the body's axes, in m, m/s and 1/s; turn: about the x axis, radians.
    """

    size: Sequence[float]
    mass: float
    position: Sequence[float]
    velocity: Sequence[float] = (0, 0, 0)
    spin: Sequence[float] = (0, 0, 0)
    turn: float = 0.0


class Setting(NamedTuple):
    """What the engines build: bodies, on half spaces through the origin with these rotations about the x axis.

    friction, restitution: of every contact; no restitution if the phenomenon does not depend on it. slope: angle by which
    gravity is turned from -z towards x, which tilts the whole scene.
    """

    bodies: tuple[Body, ...]
    friction: float
    slope: float = 0.0
    floors: tuple[float, ...] = (0.0,)
    restitution: float | None = None

    @property
    def gravity(self) -> Array:
        """(3,), m/s^2."""
        return gravity(self.slope)

    @property
    def volume_inertia(self) -> tuple[Array, ...]:
        """Return the principal moments of inertia (3,) of each body for uniform density, kg m^2."""
        return tuple(
            0.4 * body.mass * body.size[0] ** 2 * np.ones(3)
            if len(body.size) == 1
            else body.mass / 3 * (np.sum(np.square(body.size)) - np.square(body.size))
            for body in self.bodies
        )


class Unsupported(Exception):  # noqa: N818  # no error but a result about an engine
    """The engine lacks a property, which the message names."""


class World(Protocol):
    """A running simulation."""

    def run(self, seconds: float) -> None:
        """Take steps for this duration."""

    def tilt(self, slope: float) -> None:
        """Turn gravity to this slope from now on."""

    def position(self, body: int) -> Array:
        """The centre (3,), m."""

    def velocity(self, body: int) -> Array:
        """The velocity of the centre (3,), m/s."""


# Makes an engine from a setting and the step, s. Errors: ImportError if it is not installed, Unsupported.
Make = Callable[[Setting, float], World]
