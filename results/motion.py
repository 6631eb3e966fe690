"""A recorded motion of one scene: plain arrays, kept as DIR/motion/NAME.json beside the tables.

    n frames, nb bodies, all in SI units. Frame k is the state that step k ends at and step k + 1 starts from; the contacts
    and the residual of a frame are those of the step that starts there, so the last frame has none.

The ledger says where the energy went: its change since the start is friction + normal + joints + defect, and the defect is
what no force at a contact or a hinge accounts for, so it is the scheme's.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionbench.results.files import ResultsError, room, write_text

Array = NDArray[np.float64]
CURVES = ("times", "energy", "kinetic", "friction", "normal", "joints", "residual")
DIGITS = 12  # kept of each number on disk: a defect is the small difference of large energies


@dataclass(frozen=True, eq=False)
class Outline:
    """A shape to draw. body: whose frame the corners (k, 2) are in, -1 for the fixed ground. Three corners or more make a
    polygon, two a rod, one with a radius a disc. endless: the half plane left of the line through its two corners, or, with
    a negative radius, all that lies outside a circle."""

    body: int
    corners: Array
    radius: float
    endless: bool


@dataclass(frozen=True, eq=False)
class Motion:
    """times: (n,), s. poses: (n, nb, 3), x, y and angle.

    contacts: per frame (nc, 6): the point; the unit normal towards the body that is pushed, of two the upper one; the normal
    and the tangential impulse of the whole step, N s, the latter along the normal turned by -90 degrees.
    energy: (n,), kinetic and potential, J. kinetic: of it. friction, normal, joints: (n,), J, the work since the start of the
    tangential impulses, of the normal ones, and of the hinges. residual: (n,), the largest of the step's answers, possibly
    infinite. hinges: (nh, 3), a body, and the pin's place in its frame. coefficient, restitution: mu and e. ended: why the
    motion is shorter than planned, or empty.
    """

    scene: str
    parameters: dict[str, Any]
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

    @property
    def defect(self) -> Array:
        """(n,), J: the change of the energy that the ledger does not account for."""
        return self.energy - self.energy[0] - self.friction - self.normal - self.joints


def write_motion(path: Path, motion: Motion) -> None:
    """Write the motion whole or not at all."""
    room(path.parent.parent, path.parent.name)
    write_text(path, json.dumps(plain(asdict(motion), DIGITS), separators=(",", ":")))


def plain(value: Any, digits: int) -> Any:
    """The value as JSON takes it, floating-point numbers cut to so many digits."""
    if isinstance(value, dict):
        return {key: plain(entry, digits) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry, digits) for entry in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), digits)
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def read_motion(path: Path) -> Motion:
    """The motion in a file. Errors: ResultsError where it is not one."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        fields: dict[str, Any] = {name: str(found[name]) for name in ("scene", "solver", "scheme", "ended")}
        fields |= {name: float(found[name]) for name in ("step", "coefficient", "restitution")}
        fields |= {name: np.array(found[name], dtype=float) for name in ("poses", *CURVES)}
        fields["parameters"] = dict(found["parameters"])
        fields["hinges"] = _numbers(found["hinges"], 3)
        fields["contacts"] = tuple(_numbers(contacts, 6) for contacts in found["contacts"])
        fields["outlines"] = tuple(
            Outline(int(o["body"]), _numbers(o["corners"], 2), float(o["radius"]), bool(o["endless"]))
            for o in found["outlines"]
        )
        motion = Motion(**fields)
        _check(motion)
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise ResultsError(f"{path}: not a recorded motion ({type(error).__name__}: {error})") from None
    return motion


def _numbers(rows: Any, columns: int) -> Array:
    return np.array(rows, dtype=float).reshape(-1, columns)


def _check(motion: Motion) -> None:
    if motion.poses.ndim != 3 or len(motion.poses) == 0 or motion.poses.shape[2] != 3:
        raise ValueError(f"poses: expected (n, nb, 3), got {motion.poses.shape}")
    n, bodies = motion.poses.shape[:2]
    lengths = {name: getattr(motion, name).shape for name in CURVES} | {"contacts": (len(motion.contacts),)}
    if wrong := [name for name, shape in lengths.items() if shape != (n,)]:
        raise ValueError(f"{', '.join(wrong)}: not one for each of {n} frames")
    owners = [outline.body for outline in motion.outlines] + motion.hinges[:, 0].tolist()
    if not all(-1 <= owner < bodies for owner in owners):
        raise ValueError("outlines: no such body")
    arrays = (motion.poses, motion.hinges, *motion.contacts, *(outline.corners for outline in motion.outlines))
    curves = (getattr(motion, name) for name in CURVES if name != "residual")
    if not all(np.isfinite(array).all() for array in (*arrays, *curves)):
        raise ValueError("a number is not finite")
