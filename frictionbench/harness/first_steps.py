"""The first steps of a map's scene at its grid points, by exact answers, so that a reader sees what a tile stands for."""

from pathlib import Path

from frictionbench.harness.cells.motion import record_motion
from frictionbench.problems.scenes import scene
from frictionbench.results.maps import FirstSteps, Map, first_steps_file, write_first_steps

STEPS, EVERY = 12, 4  # steps, and steps between two frames
LINES = 8  # grid lines of each axis at most: a picture of another tile is the nearest of these
SOLVER = "hybrid"


def store_first_steps(spec: Map, folder: Path) -> None:
    """Write the first steps to folder, unless they have been written; of scenes in the plane."""
    if scene(spec.scene, **spec.at((0.0, 0.0))).dimension != 2 or first_steps_file(folder, spec).exists():
        return
    found = []
    for point in ((float(i), float(j)) for i in spec.x.lines(LINES) for j in spec.y.lines(LINES)):
        motion = record_motion(scene(spec.scene, **spec.at(point)), SOLVER, spec.scheme, STEPS)
        found.append(FirstSteps(point, motion.outlines, motion.poses[::EVERY]))
    write_first_steps(folder, spec, found)
