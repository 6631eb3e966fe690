"""The first steps of a scene in the plane as paths of SVG, in which y points down."""

import numpy as np

from frictionbench.results.maps import FirstSteps
from frictionbench.results.motion import Array, Outline

MARGIN = 0.15  # around the bodies, relative to their size


def picture(found: FirstSteps) -> dict[str, object]:
    """at: the grid point. view: of the SVG. ground: a path. frames: a path each, the earliest first."""
    moving = [outline for outline in found.outlines if outline.body >= 0]
    places = [_placed(outline, pose) for pose in found.poses for outline in moving]
    low, high = (
        (np.min([place.min(axis=0) for place in places], axis=0), np.max([place.max(axis=0) for place in places], axis=0))
        if places
        else (-np.ones(2), np.ones(2))
    )
    margin = MARGIN * max(float((high - low).max()), 1e-9)
    box = low - margin, high + margin
    still = [outline for outline in found.outlines if outline.body < 0]
    return {
        "at": found.point,
        "view": " ".join(f"{value:.5g}" for value in (box[0][0], -box[1][1], *(box[1] - box[0]))),
        "ground": "".join(_svg_path(_ground(outline, box), closed=not outline.endless) for outline in still),
        "frames": ["".join(_svg_path(_placed(outline, pose)) for outline in moving) for pose in found.poses],
    }


def _placed(outline: Outline, pose: Array) -> Array:
    """The corners (k, 2) of a body's shape, of a disc those of a polygon, and its radius to show how it turns."""
    x, y, angle = pose[outline.body]
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    placed: Array = _outline_corners(outline) @ turn + (x, y)
    return placed


def _outline_corners(outline: Outline) -> Array:
    if not outline.radius:
        return outline.corners
    around = np.linspace(0, 2 * np.pi, 25)
    circle = abs(outline.radius) * np.column_stack([np.cos(around), np.sin(around)])
    return np.vstack([outline.corners[:1] + circle, outline.corners[:1]])


def _ground(outline: Outline, box: tuple[Array, Array]) -> Array:
    """The shape; the surface of a half plane as far as it is seen in the box between the lowest and the highest corner."""
    if not outline.endless or len(outline.corners) < 2:
        return _outline_corners(outline)
    a, b = outline.corners[:2]
    along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-300)
    middle = a + along * float(along @ ((box[0] + box[1]) / 2 - a))
    far = 2 * float(np.linalg.norm(box[1] - box[0]))
    return np.stack([middle - far * along, middle + far * along])


def _svg_path(corners: Array, closed: bool = True) -> str:
    return "M" + "L".join(f"{x:.5g} {-y:.5g}" for x, y in corners) + "Z" * closed
