"""The first steps of a map's scene at some of its grid points, for a picture: DIR/maps/NAME-steps.json."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from frictionbench.results.files import ResultsError, read_json, subfolder, write_text
from frictionbench.results.map_spec import GridPoint, Map
from frictionbench.results.motion import Array, Outline, outlines, plain

DIGITS = 5  # finer than a pixel


@dataclass(frozen=True, eq=False)
class FirstSteps:
    """point: positions on the two axes. outlines: of all shapes, in the plane. poses: (frames, nb, 3), as of a motion."""

    point: GridPoint
    outlines: tuple[Outline, ...]
    poses: Array


def first_steps_file(folder: Path, spec: Map) -> Path:
    return folder / "maps" / f"{spec.name}-steps.json"


def write_first_steps(folder: Path, spec: Map, found: Sequence[FirstSteps]) -> None:
    path = first_steps_file(folder, spec)
    subfolder(folder, path.parent.name)
    write_text(path, json.dumps([plain(asdict(one), DIGITS) for one in found], separators=(",", ":")))


def read_first_steps(folder: Path, spec: Map) -> list[FirstSteps]:
    """What was recorded, empty where nothing was. Errors: ResultsError if the file cannot be read."""
    path = first_steps_file(folder, spec)
    if not path.exists():
        return []
    try:
        return [_checked(one) for one in read_json(path)]
    except (ValueError, TypeError, LookupError, AttributeError, OverflowError) as error:
        raise ResultsError(f"{path}: cannot be read ({type(error).__name__}: {error})") from None


def _checked(one: dict[str, object]) -> FirstSteps:
    i, j = one["point"]  # type: ignore[misc]
    found = FirstSteps((float(i), float(j)), outlines(one["outlines"], 2), np.array(one["poses"], dtype=float))  # type: ignore[has-type]
    poses = found.poses
    if poses.ndim != 3 or len(poses) == 0 or poses.shape[2] != 3:
        raise ValueError(f"poses: expected (frames, nb, 3), got {poses.shape}")
    if not all(-1 <= outline.body < poses.shape[1] for outline in found.outlines):
        raise ValueError("outlines: the index of a body is out of range")
    numbers = np.concatenate([found.point, poses.ravel(), *(np.append(o.corners, o.radius) for o in found.outlines)])
    if not np.isfinite(numbers).all():
        raise ValueError("a number is not finite")
    return found
