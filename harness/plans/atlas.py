"""The maps of the suite `maps`: where in the space of physical parameters theory, problems and methods change."""

import math

from frictionbench.results.map_spec import Axis, Map

GAPS = "stewart_trinkle"
FORCES = "acceleration"


def _friction(low: float, high: float, count: int = 8) -> Axis:
    return Axis("friction", low, high, count)


def _size(parameter: str, high: int, count: int = 7, low: int = 1) -> Axis:
    return Axis(parameter, low, high, count, "log", whole=True)


ROD = (
    Map(
        name="painleve_rod",
        scene="painleve_rod",
        x=Axis("angle", 0.3, 1.5, 10),
        y=_friction(0.4, 3.1, 10),
        parameters={"step": 1e-4},
        thresholds=("p",),
        title="Painlevé's rod, impulses",
        note="Where p < 0 sliding is no solution: the tip sticks by an impulse. There is one solution everywhere.",
    ),
    Map(
        name="painleve_rod_lifting",
        scene="painleve_rod",
        x=Axis("angle", 0.3, 1.5, 10),
        y=_friction(0.4, 3.1, 10),
        parameters={"lift": 0.002, "step": 1e-4},
        thresholds=("p",),
        title="Painlevé's rod whose tip lifts",
        note="Where p < 0 there are three solutions: open, stick and slide. Which of them a method finds is its own affair.",
    ),
    Map(
        name="painleve_rod_forces",
        scene="painleve_rod",
        x=Axis("angle", 0.3, 1.5, 10),
        y=_friction(0.4, 3.1, 10),
        parameters={"step": 1e-4},
        scheme=FORCES,
        thresholds=("p",),
        title="Painlevé's rod, forces",
        note="The rod slides on a swift belt, so that a bounded force is a sliding contact; where p < 0 there is none, and the "
        "answer, sticking to the belt, is a force without bound.",
    ),
)
CORNERS = (
    Map(
        name="sliding_block",
        scene="two_corner_block",
        x=Axis("aspect", 0.3, 3.0, 10),
        y=_friction(0.3, 3.9, 10),
        thresholds=("P0", "p"),
        title="Sliding block on two corners",
        note="The LCP's matrix is P0 up to friction times height over width = 1, which is where the sliding block tips over: "
        "from there on its rear corner opens.",
    ),
    Map(
        name="two_corner_block",
        scene="two_corner_block",
        x=Axis("aspect", 0.3, 3.0, 10),
        y=_friction(0.3, 3.9, 10),
        parameters={"velocity": 0.97, "fall": -0.18, "spin": -0.16},
        thresholds=("P0", "p"),
        title="Block thrown onto two corners",
        note="Where the matrix is P0 the solution is unique. Beyond, some velocities have three, and this is one of them.",
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
        note="The normals cancel. With a gap there is a solution; an overlap asks for a speed away from both walls at once, "
        "and there is none, though one too small to be seen in the residual is let pass.",
    ),
    Map(
        name="wedge",
        scene="wedge",
        x=Axis("angle", 0.1, 1.3, 9),
        y=_friction(0.1, 2.5, 9),
        thresholds=("pointed",),
        title="Disc in a wedge",
        note="Where friction >= tan(angle) the walls can press against each other through the disc without bound.",
    ),
    Map(
        name="penetration",
        scene="wedge",
        x=Axis("depth", 1e-8, 1e-1, 8, "zero"),
        y=_friction(0.1, 1.5),
        scheme=GAPS,
        thresholds=("gaps", "pointed"),
        title="Disc sunk into a wedge",
        note="An overlap asks for a speed out of the wall. While the cone is pointed there is a solution; beyond, counting all "
        "solutions says whether there is one.",
    ),
    Map(
        name="redundant_table",
        scene="redundant_table",
        x=Axis("legs", 2, 20, 7, "log", whole=True),
        y=_friction(0.1, 1.5),
        parameters={"speed": 1.0},
        title="Table on many legs",
        note="Only the resultant is determined.",
    ),
    Map(
        name="slider_crank",
        scene="slider_crank",
        x=Axis("angle", 0.1, 6.1, 9),
        y=_friction(0.0, 1.4),
        parameters={"clearance": 0.0},
        thresholds=("pointed",),
        title="Slider–crank without clearance",
        note="A chain of hinges ends between two guides whose normals cancel.",
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
        note="Hyperstatic: two contacts an interface, of which any share is right.",
    ),
    Map(
        name="stack_mass_ratio",
        scene="stack",
        x=_size("blocks", 20, 6),
        y=Axis("mass_ratio", 1e-6, 1e6, 9, "log"),
        parameters={"push": 1.0},
        title="Stack of unlike masses",
        note="The topmost box has so many times the mass of the lowest.",
    ),
    Map(
        name="stack_jitter",
        scene="stack",
        x=_size("blocks", 20, 6),
        y=Axis("jitter", 1e-12, 1e-2, 7, "zero"),
        parameters={"push": 1.0},
        title="Stack of nearly equal boxes",
        note="From exact ties, at 0, to near ties and none.",
    ),
    Map(
        name="pyramid",
        scene="pyramid",
        x=_size("rows", 9, 6),
        y=_friction(0.05, 1.1),
        parameters={"push": 1.0},
        title="Pyramid, the topmost box pushed",
        note="Boxes that rest on two.",
    ),
    Map(
        name="wall",
        scene="wall",
        x=_size("rows", 7, 6),
        y=_friction(0.05, 1.1),
        parameters={"push": 1.0, "columns": 4},
        title="Brick wall, the lowest left brick pushed",
        note="Flush on all sides: every contact is a tie, and more contacts than freedoms.",
    ),
    Map(
        name="arch",
        scene="arch",
        x=_size("stones", 25, 6, low=3),
        y=_friction(0.05, 1.1),
        parameters={"push": 0.1},
        title="Arch, its middle stone pushed",
        note="Stones that interlock.",
    ),
    Map(
        name="sheared_stack",
        scene="stack",
        x=Axis("shear", 1e-3, 1e2, 6, "log"),
        y=_friction(0.05, 1.1),
        parameters={"blocks": 15},
        title="Sheared stack of 15 boxes",
        note="The higher the faster.",
    ),
    Map(
        name="pushed_pyramid",
        scene="pyramid",
        x=Axis("shear", 1e-3, 1e2, 6, "log"),
        y=_friction(0.05, 1.1),
        parameters={"rows": 7, "push": 1.0},
        title="Sheared pyramid of seven rows, its top pushed",
        note="Here an interior point is trapped, and the path's folds have to be followed.",
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
        note="The same problem in other numbers, powers of two from 1e-12 to 1e12, so that not even round-off differs: nothing "
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
        note="As many as 30 steps of each size.",
    )
    for name, title, low, high, parameters in (
        ("bowl", "bead in a bowl", 0.0, 0.9, {}),
        ("stack", "three boxes, the lowest pushed", 0.05, 0.95, {"blocks": 3, "push": 1.0}),
        ("painleve_rod", "rod", 0.4, 2.5, {}),
    )
)
ATLAS = (*ROD, *CORNERS, *PILES, *UNITS, *LOOPS)
