"""Single steps kept as files, because what made them is not in this project: candidates of the suite `hard`.

near_jam               a pair of vertices with nearly opposite normals, 6 contacts
false_ray_bar_*        steps of a long bar on three posts, and false_ray_blocks_* of three blocks, by their Delassus matrices,
                       on which a dense tableau of Lemke's method ends on a ray though there is a solution
locked_*               contacts on planar bodies that redundant joints lock
friction_1e-6_to_1e6   planar, with such coefficients of friction
heavy_top              a planar stack in which each block is heavier than the one below, to a ratio of 1e10
discs, bodies          a planar pile of discs, 290 contacts; planar random bodies, 210 contacts
friction_1e3_*         in space; masses_1e6, masses_1e8: of spatial bodies
wall_*                 walls of boxes in space, with 4 or 8 contacts a face
"""

from pathlib import Path

from frictionbench.problems.catalogue import instance
from frictionbench.problems.check import require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded import own

FOLDER = Path(__file__).parent / "steps"


def recorded_steps() -> list[str]:
    """The names of all kept steps, in alphabetical order."""
    return sorted(path.stem for path in FOLDER.glob("*.npz"))


@instance
def recorded_step(case: str = "near_jam") -> FrictionProblem:
    """A single step that is kept as a file, by its name: see problems.instances.recorded_step."""
    known = recorded_steps()
    require(case in known, "case", f"unknown step {case!r}; known are {', '.join(known)}")
    problem = own.load(FOLDER / f"{case}.npz")
    assert isinstance(problem, FrictionProblem)
    return problem
