"""A recorded motion of one scene as plain arrays.

There are n frames and nb bodies; all units are SI. Frame k is the state at the end of step k, from which step k + 1 starts. The
contacts and the residual of a frame are those of the step that starts there, so that the last frame has none.

Energy balance: the change of energy since the start is friction + normal + joints + defect, where the first three are the work
of tangential impulses, normal impulses and hinges, and the defect is the error of the time-stepping scheme.
"""

import json
from dataclasses import asdict
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, ConfigDict
from pydantic.dataclasses import dataclass

from frictionbench.results.conventions import scene_title
from frictionbench.results.files import parsed

Array = Annotated[NDArray[np.float64], BeforeValidator(lambda values: np.array(values, dtype=float))]
ARRAYS = ConfigDict(arbitrary_types_allowed=True)
CURVES = ("times", "energy", "kinetic", "friction", "normal", "joints", "residual")
TITLE_DIGITS = 3  # digits of a parameter in a title


@dataclass(frozen=True, eq=False, config=ARRAYS)
class Outline:
    """A shape to draw. body: the body in whose frame the corners (k, d) are given, -1 for the fixed ground.

    In the plane three or more corners are a polygon, two a rod, one with a radius a disc. If endless, two are the half plane to
    the left of their line, and one with a negative radius is the outside of a circle. In space eight corners, ascending, are a
    box, one with a radius is a sphere, and two, if endless, are a point on the boundary of a half space and its normal.
    """

    body: int
    corners: Array
    radius: float
    endless: bool


@dataclass(frozen=True, eq=False, config=ARRAYS)
class Motion:
    """parameters: all parameters of the scene; changed: those that differ from its defaults.
    times: (n,), s. poses: (n, nb, 3), x, y and angle; in space (n, nb, 7), x, y, z and a quaternion, w first.

    contacts: per frame (nc, 6): the point; the unit normal towards the body that is pushed, which is the upper one of two; the
    normal and the tangential impulse of the whole step, N s, the latter along the normal turned by -90 degrees. In space
    (nc, 9): the point, the normal, and the vector of the impulse.
    energy: (n,), kinetic plus potential, J. kinetic: (n,), J. friction, normal, joints: (n,), J, the work since the start of
    the tangential impulses, the normal impulses and the hinges. residual: (n,), the largest residual of the step's answers,
    possibly infinite. hinges: (nh, 3), a body and the position of the pin in its frame. coefficient, restitution: mu and e.
    ended: why the motion is shorter than planned, or empty.
    """

    scene: str
    parameters: dict[str, Any]
    changed: dict[str, Any]
    solver: str
    scheme: str
    step: float
    coefficient: float
    restitution: float
    ended: str
    outlines: tuple[Outline, ...]
    hinges: Array
    times: Array
    poses: Array
    contacts: tuple[Array, ...]
    energy: Array
    kinetic: Array
    friction: Array
    normal: Array
    joints: Array
    residual: Array

    def __post_init__(self) -> None:
        if self.poses.ndim != 3 or len(self.poses) == 0 or self.poses.shape[2] not in (3, 7):
            raise ValueError(f"poses: expected (n, nb, 3) or (n, nb, 7), got {self.poses.shape}")
        n, bodies = self.poses.shape[:2]
        lengths = {name: getattr(self, name).shape for name in CURVES} | {"contacts": (len(self.contacts),)}
        if wrong := [name for name, shape in lengths.items() if shape != (n,)]:
            raise ValueError(f"{', '.join(wrong)}: expected one value for each of {n} frames")
        # Empty lists are read as arrays without columns.
        vars(self)["contacts"] = tuple(each.reshape(-1, 3 * self.dimension) for each in self.contacts)
        vars(self)["hinges"] = self.hinges.reshape(-1, 3)
        owners = [outline.body for outline in self.outlines] + self.hinges[:, 0].tolist()
        if not all(-1 <= owner < bodies for owner in owners):
            raise ValueError("outlines: the index of a body is out of range")
        arrays = (self.poses, self.hinges, *self.contacts, *(outline.corners for outline in self.outlines))
        curves = (getattr(self, name) for name in CURVES if name != "residual")
        if not all(np.isfinite(array).all() for array in (*arrays, *curves)):
            raise ValueError("a number is not finite")

    @property
    def dimension(self) -> int:
        """d: 2 in the plane, 3 in space."""
        return 3 if self.poses.shape[2] == 7 else 2

    @property
    def title(self) -> str:
        """The scene with its changed parameters to three digits."""
        return scene_title(self.scene, json.dumps(plain(self.changed, TITLE_DIGITS)))

    @property
    def defect(self) -> Array:
        """(n,), J: the change of energy that is not the work of contacts and hinges."""
        return self.energy - self.energy[0] - self.friction - self.normal - self.joints


def encoded(motion: Motion) -> dict[str, Any]:
    """Return the motion in types of JSON, with every digit: a defect is a small difference of large energies."""
    return {name: plain(value) for name, value in asdict(motion).items()}


def plain(value: Any, digits: int = 17) -> Any:
    """Return the value in types of JSON, with floating-point numbers rounded to this many significant digits; 17 are all."""
    if isinstance(value, dict):
        return {key: plain(item, digits) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, digits) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), digits)
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def decoded(value: Any, origin: str) -> Motion:
    """Return an encoded motion. Errors: ResultsError naming the origin if it is not a recorded motion."""
    return parsed(value, Motion, origin)
