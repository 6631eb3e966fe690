"""Single steps stored as files, because the code that made them is not in this project: candidates for the suite `hard`.

near_jam               a pair of vertices with nearly opposite normals, 6 contacts
false_ray_bar_*        steps of a long bar on three posts, given by their Delassus matrices, and false_ray_blocks_*, of three
                       blocks: a dense tableau of Lemke's method ends on a ray, although there is a solution
locked_*               contacts on planar bodies that redundant joints lock
friction_1e-6_to_1e6   planar, with coefficients of friction in this range
heavy_top              a planar stack in which each block is heavier than the one below, with a total mass ratio of 1e10
discs, bodies          a planar pile of discs, 290 contacts; planar random bodies, 210 contacts
friction_1e3_*         spatial, with coefficients up to 1e3; masses_1e6, masses_1e8: spatial, with these mass ratios
wall_*                 walls of boxes in space, with 4 or 8 contacts per face

robot_step has steps of robots, whose models come from other packages and were simulated by MuJoCo, by model, behaviour and
number of the step (docs/robots.md; `python -m tools.robots.record` records and selects them).
"""

from pathlib import Path

from frictionbench.problems.catalogue import instance, near
from frictionbench.problems.check import require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded import native

FOLDER = Path(__file__).parent / "steps"
ROBOTS = FOLDER / "robots"
NAMES_SHOWN = 12  # names in an error


def recorded_steps(folder: Path = FOLDER) -> list[str]:
    """The names of all stored steps, in alphabetical order."""
    return sorted(path.stem for path in folder.glob("*.npz"))


@instance(dimension=2)
def recorded_step(case: str = "near_jam") -> FrictionProblem:
    """A single step stored as a file, by its name: see problems.instances.recorded_step. Some are spatial."""
    return _kept(FOLDER, case)


@instance()
def robot_step(case: str = "humanoid-hit-064") -> FrictionProblem:
    """A step of a robot, by its name, with joint limits and dry friction of joints as contacts: see docs/robots.md."""
    return _kept(ROBOTS, case)


def _kept(folder: Path, case: str) -> FrictionProblem:
    known = recorded_steps(folder)
    some = ", ".join(known[:NAMES_SHOWN]) + (f" and {len(known) - NAMES_SHOWN} more" if len(known) > NAMES_SHOWN else "")
    require(case in known, "case", f"unknown step {case!r:.100}{near(str(case), known)}; known are {some}")
    problem = native.load(folder / f"{case}.npz")
    assert isinstance(problem, FrictionProblem)
    return problem
