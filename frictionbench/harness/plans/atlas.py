"""The maps of the suite `maps`: how existence, solutions and verdicts depend on the physical parameters of scenes."""

import math
from dataclasses import replace

from frictionbench.results.maps import Axis, Map

GAPS = "stewart_trinkle"  # the scheme whose contacts keep their gaps
FORCES = "acceleration"  # the scheme whose unknowns are forces


def _friction(low: float, high: float, count: int = 8) -> Axis:
    return Axis("friction", low, high, count)


def _size(parameter: str, high: int, count: int = 7, low: int = 1) -> Axis:
    return Axis(parameter, low, high, count, "log", whole=True)


ROD = Map(
    name="painleve_rod",
    scene="painleve_rod",
    x=Axis("angle", 0.3, 1.5, 10),
    y=_friction(0.4, 3.1, 10),
    parameters={"step": 1e-4},
    thresholds=("p",),
    title="Painlevé's rod, impulses",
    note="Where p < 0 sliding is not a solution: the tip sticks by an impulse. The solution is unique everywhere.",
)
RODS = (
    ROD,
    replace(
        ROD,
        name="painleve_rod_lifting",
        parameters={"lift": 0.002, "step": 1e-4},
        title="Painlevé's rod whose tip lifts",
        note="Where p < 0 there are three solutions: open, stick and slide. A method may find any of them.",
    ),
    replace(
        ROD,
        name="painleve_rod_forces",
        scheme=FORCES,
        title="Painlevé's rod, forces",
        note="The rod slides on a fast belt, so that a bounded force means sliding. Where p < 0 no bounded force is a "
        "solution, and the answer, sticking to the belt, is an unbounded force.",
    ),
)
BLOCK = Map(
    name="sliding_block",
    scene="two_corner_block",
    x=Axis("aspect", 0.3, 3.0, 10),
    y=_friction(0.3, 3.9, 10),
    thresholds=("P0", "p"),
    title="Sliding block on two corners",
    note="The LCP's matrix is P0 up to friction times height over width = 1, where the sliding block tips over: beyond, "
    "its rear corner opens.",
)
CORNERS = (
    BLOCK,
    replace(
        BLOCK,
        name="two_corner_block",
        parameters={"velocity": 0.97, "fall": -0.18, "spin": -0.16},
        title="Block thrown onto two corners",
        note="Where the matrix is P0 the solution is unique. Beyond, there are three for some velocities, of which this is "
        "one.",
    ),
    Map(
        name="jam",
        scene="jam",
        x=Axis("overlap", 1e-12, 1e-1, 13, "both"),
        y=_friction(0.05, 2.05),
        parameters={"sideways": 0.1},
        scheme=GAPS,
        thresholds=("gaps", "pointed"),
        title="Disc between two walls, gaps to overlaps",
        note="The normals are opposite. With a gap there is a solution; an overlap requires velocities away from both walls "
        "at once, which is impossible, but an overlap too small to show in the residual passes as solved.",
    ),
    Map(
        name="wedge",
        scene="wedge",
        x=Axis("angle", 0.1, 1.3, 9),
        y=_friction(0.1, 2.5, 9),
        parameters={"spin": 0.0},
        thresholds=("pointed",),
        title="Disc in a wedge",
        note="Where friction >= tan(angle) the walls can press on the disc with unbounded impulses.",
    ),
    Map(
        name="penetration",
        scene="wedge",
        x=Axis("depth", 1e-8, 1e-1, 8, "zero"),
        y=_friction(0.1, 1.5),
        parameters={"spin": 0.0},
        scheme=GAPS,
        thresholds=("gaps", "pointed"),
        title="Disc sunk into a wedge",
        note="An overlap requires a velocity away from the wall. While the cone is pointed there is a solution; beyond, "
        "existence is decided by enumerating all solutions.",
    ),
    Map(
        name="redundant_table",
        scene="redundant_table",
        x=Axis("legs", 2, 20, 7, "log", whole=True),
        y=_friction(0.1, 1.5),
        parameters={"speed": 1.0},
        title="Table on many legs",
        note="Only the resultant of the impulses is unique.",
    ),
    Map(
        name="slider_crank",
        scene="slider_crank",
        x=Axis("angle", 0.1, 6.1, 9),
        y=_friction(0.0, 1.4),
        parameters={"clearance": 0.0},
        thresholds=("pointed",),
        title="Slider–crank without clearance",
        note="A chain of hinges ends between two guides with opposite normals.",
    ),
)
PILES = (
    Map(
        name="stack",
        scene="stack",
        x=_size("blocks", 40),
        y=_friction(0.05, 1.1),
        parameters={"push": 1.0},
        title="Stack, the lowest box pushed",
        note="Hyperstatic: the two contacts of an interface may share its impulse in any way.",
    ),
    Map(
        name="stack_mass_ratio",
        scene="stack",
        x=_size("blocks", 20, 6),
        y=Axis("mass_ratio", 1e-6, 1e6, 9, "log"),
        parameters={"push": 1.0},
        title="Stack of unlike masses",
        note="The mass of the top box relative to that of the lowest.",
    ),
    Map(
        name="stack_jitter",
        scene="stack",
        x=_size("blocks", 20, 6),
        y=Axis("jitter", 1e-12, 1e-2, 7, "zero"),
        parameters={"push": 1.0},
        title="Stack of nearly equal boxes",
        note="From exact ties, at 0, over near ties to none.",
    ),
    Map(
        name="pyramid",
        scene="pyramid",
        x=_size("rows", 9, 6),
        y=_friction(0.05, 1.1),
        parameters={"push": 1.0},
        title="Pyramid, the topmost box pushed",
        note="Every box rests on two.",
    ),
    Map(
        name="wall",
        scene="wall",
        x=_size("rows", 7, 6),
        y=_friction(0.05, 1.1),
        parameters={"push": 1.0, "columns": 4},
        title="Brick wall, the lowest left brick pushed",
        note="Bricks flush on all sides: every contact is a tie, and there are more contacts than degrees of freedom.",
    ),
    Map(
        name="arch",
        scene="arch",
        x=_size("stones", 25, 6, low=3),
        y=_friction(0.05, 1.1),
        parameters={"push": 0.1},
        title="Arch, its middle stone pushed",
        note="Interlocking stones.",
    ),
    Map(
        name="sheared_stack",
        scene="stack",
        x=Axis("shear", 1e-3, 1e2, 6, "log"),
        y=_friction(0.05, 1.1),
        parameters={"blocks": 15, "push": 0.0},
        title="Sheared stack of 15 boxes",
        note="Velocity grows with height.",
    ),
    Map(
        name="pushed_pyramid",
        scene="pyramid",
        x=Axis("shear", 1e-3, 1e2, 6, "log"),
        y=_friction(0.05, 1.1),
        parameters={"rows": 7, "push": 1.0},
        title="Sheared pyramid of seven rows, its top pushed",
        note="Interior point methods may stall here, and path-following methods meet folds of the path.",
    ),
)
UNITS = tuple(
    Map(
        name=f"units_{name}",
        scene=name,
        x=Axis("mass_unit", 2.0**-40, 2.0**40, 5, "log"),
        y=Axis("length_unit", 2.0**-40, 2.0**40, 5, "log"),
        parameters=parameters,
        constant=True,
        title=f"Units of mass and length: {title}",
        note="The same problem in other units, powers of two from 1e-12 to 1e12, so that not even rounding differs: nothing "
        "may change.",
    )
    for name, title, parameters in (
        ("stack", "five boxes", {"blocks": 5, "push": 1.0}),
        ("painleve_rod", "rod", {"angle": math.atan(2.0)}),
        ("pyramid", "pyramid", {"rows": 4, "push": 1.0}),
    )
)
LOOPS = tuple(
    Map(
        name=f"steps_{name}",
        scene=name,
        x=Axis("step", 1e-4, 1.0, 5, "log"),
        y=_friction(low, high, 4),
        parameters=parameters,
        scheme=GAPS,
        steps=30,
        levels=0,
        title=f"Step size in closed loop: {title}",
        note="At most 30 steps of each size.",
    )
    for name, title, low, high, parameters in (
        ("bowl", "bead in a bowl", 0.0, 0.9, {}),
        ("stack", "three boxes, the lowest pushed", 0.05, 0.95, {"blocks": 3, "push": 1.0}),
        ("painleve_rod", "rod", 0.4, 2.5, {}),
    )
)
ATLAS = (*RODS, *CORNERS, *PILES, *UNITS, *LOOPS)
