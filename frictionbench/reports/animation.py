"""A motion as one self-contained HTML page: the bodies, the impulses in their friction cones, and the energy balance.

The page holds the motion as JSON and a short script that draws it (templates/animation.js), and loads nothing. Names may come
from an untrusted source. Therefore text is escaped, the JSON contains no "<", and the page's policy allows only this script.
"""

from pathlib import Path
from typing import Any

import numpy as np

from frictionbench.reports.templates import as_json, write_page
from frictionbench.results.motion import Array, Motion, Outline, plain

MOST_NUMBERS = 250_000  # numbers on a page, which is then about 2 MB
DRAWN_DIGITS = 5  # significant digits of each number, finer than a pixel
VIEW_MARGIN = 0.1  # around the motion, relative to its size


def write_animation(motion: Motion, path: Path) -> Path:
    """Write the page; return its path."""
    facts = {"title": motion.title, "frames": len(motion.times), "data": as_json(_data(motion))}
    return write_page(path, "animation.html", motion=motion, **facts)


def _data(motion: Motion) -> dict[str, Any]:
    """Return the data that the script draws: every frame, or every k-th frame of a long motion. Between two frames the contacts
    of the step with the largest impulses are shown, so that no impact is missed."""
    n = len(motion.times)
    numbers = motion.poses.size + 8 * n + sum(contacts.size for contacts in motion.contacts)
    every = -(-numbers // MOST_NUMBERS)
    size = np.array([np.abs(contacts[:, 2 * motion.dimension :]).sum() for contacts in motion.contacts])
    shown = [k + int(size[k : k + every].argmax()) for k in range(0, n, every)]
    curves = {name: getattr(motion, name)[::every] for name in ("times", "energy", "kinetic", "friction", "normal", "joints")}
    data = curves | {
        "defect": motion.defect[::every],
        "residual": [value if np.isfinite(value) else None for value in motion.residual[shown].tolist()],
        "poses": motion.poses[::every].reshape(len(shown), -1),
        "contacts": [motion.contacts[k].ravel() for k in shown],
        "step": motion.step,
        "mu": motion.coefficient,
        "outlines": [{**vars(outline), "corners": outline.corners.ravel()} for outline in motion.outlines],
        "pins": motion.hinges,
        "space": motion.dimension == 3,
        "centre": _centre(motion),
        "view": _view(motion),
        "size": _size(motion),
    }
    return plain(data, DRAWN_DIGITS)


def _size(motion: Motion) -> float:
    """Return the length for the arrows, m: a body's size or, if bodies are few and small, a share of the picture's size."""
    left, bottom, right, top = _view(motion)
    sizes = [float(np.ptp(outline.corners, axis=0).max()) + 2 * outline.radius for outline in _moving(motion)]
    return max(float(np.median(sizes)) if sizes else 0.0, max(right - left, top - bottom) / (motion.poses.shape[1] + 2))


def _moving(motion: Motion) -> list[Outline]:
    return [outline for outline in motion.outlines if outline.body >= 0]


def _view(motion: Motion) -> Array:
    """Return the bounding box (left, bottom, right, top) of all moving bodies over the whole motion, with a margin. In space it
    is a square about their centre that holds them for every viewing direction."""
    if motion.dimension == 3:
        reach = _reach(motion) + float(np.linalg.norm(motion.poses[..., :3] - _centre(motion), axis=2).max(initial=0.0))
        return (1 + VIEW_MARGIN) * reach * np.array([-1.0, -1.0, 1.0, 1.0])
    if not _moving(motion):
        return np.array([-1.0, -1.0, 1.0, 1.0])
    places, reach = motion.poses[..., :2], _reach(motion)
    low, high = places.min(axis=(0, 1)) - reach, places.max(axis=(0, 1)) + reach
    margin = VIEW_MARGIN * max(float((high - low).max()), 1e-9)
    return np.concatenate([low - margin, high + margin])


def _centre(motion: Motion) -> Array:
    """Return the centre (d,) of the bounding box of all bodies' positions."""
    places = motion.poses[..., : motion.dimension].reshape(-1, motion.dimension)
    return (places.min(axis=0) + places.max(axis=0)) / 2 if len(places) else np.zeros(motion.dimension)


def _reach(motion: Motion) -> float:
    """Return the largest distance of a body's point from its origin, m."""
    return max((float(np.linalg.norm(o.corners, axis=1).max()) + o.radius for o in _moving(motion)), default=0.0)
