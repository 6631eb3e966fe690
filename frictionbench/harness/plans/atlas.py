"""The maps of the suite `maps`: how existence, solutions and verdicts depend on the physical parameters of scenes.

The axes are written as on the command line:

    friction=.1:3:30               30 values from .1 to 3, both ends among them
    mass_ratio=log:1e-6:1e6:13     13 values, a constant factor apart
    jitter=zero:1e-12:1e-2:7       0 and six values, a constant factor apart
    overlap=both:1e-12:1e-1:13     -1e-1 ... -1e-12, 0, 1e-12 ... 1e-1
"""

import math
from typing import Any, get_args

from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scenes
from frictionbench.problems.check import require
from frictionbench.problems.spec import parse
from frictionbench.results.maps import Axis, Map, Scale

GAP_SCHEME = "stewart_trinkle"  # the scheme whose problems contain the contacts' gaps
SCALES = get_args(Scale)
MOST_LINES = 200  # values along an axis: finer than a map can show
UNIT = f"log:{2.0**-40!r}:{2.0**40!r}:5"  # powers of two from 1e-12 to 1e12, so that not even rounding differs

# Each map has three parts: name, scene, both axes, thresholds and the scheme if not the default; the title; the note.
_MAPS = """
painleve_rod  painleve_rod[step=1e-4]  angle=0.3:1.5:10  friction=0.4:3.1:10  p
    Painlevé's rod, impulses
    Where p < 0 sliding is not a solution: the tip sticks by an impulse. The solution is unique everywhere.

painleve_rod_lifting  painleve_rod[lift=0.002,step=1e-4]  angle=0.3:1.5:10  friction=0.4:3.1:10  p
    Painlevé's rod whose tip lifts
    Where p < 0 there are three solutions: open, stick and slide. A method may find any of them.

painleve_rod_forces  painleve_rod[step=1e-4]  angle=0.3:1.5:10  friction=0.4:3.1:10  p  scheme=acceleration
    Painlevé's rod, forces
    The rod slides on a fast belt, so that a bounded force means sliding. Where p < 0 no bounded force is a solution,
    and the answer, sticking to the belt, is an unbounded force.

sliding_block  two_corner_block  aspect=0.3:3:10  friction=0.3:3.9:10  P0 p
    Sliding block on two corners
    The LCP's matrix is P0 up to friction times height over width = 1, where the block tips over: beyond, its rear corner opens.

two_corner_block  two_corner_block[velocity=0.97,fall=-0.18,spin=-0.16]  aspect=0.3:3:10  friction=0.3:3.9:10  P0 p
    Block thrown onto two corners
    Where the matrix is P0 the solution is unique. Beyond, there are three for some velocities, of which this is one.

jam  jam[sideways=0.1]  overlap=both:1e-12:0.1:13  friction=0.05:2.05:8  gaps pointed  scheme=stewart_trinkle
    Disc between two walls, gaps to overlaps
    The normals are opposite. With a gap there is a solution; an overlap requires velocities away from both walls at
    once, which is impossible, but an overlap too small to show in the residual passes as solved.

wedge  wedge[spin=0.0]  angle=0.1:1.3:9  friction=0.1:2.5:9  pointed
    Disc in a wedge
    Where friction >= tan(angle) the walls can press on the disc with unbounded impulses.

penetration  wedge[spin=0.0]  depth=zero:1e-08:0.1:8  friction=0.1:1.5:8  gaps pointed  scheme=stewart_trinkle
    Disc sunk into a wedge
    An overlap requires a velocity away from the wall. While the cone is pointed there is a solution; beyond, existence
    is decided by enumerating all solutions.

redundant_table  redundant_table[speed=1.0]  legs=log:2:20:7  friction=0.1:1.5:8
    Table on many legs
    Only the resultant of the impulses is unique.

slider_crank  slider_crank[clearance=0.0]  angle=0.1:6.1:9  friction=0:1.4:8  pointed
    Slider–crank without clearance
    A chain of hinges ends between two guides with opposite normals.

stack  stack[push=1.0]  blocks=log:1:40:7  friction=0.05:1.1:8
    Stack, the lowest box pushed
    Hyperstatic: the two contacts of an interface may share its impulse in any way.

stack_mass_ratio  stack[push=1.0]  blocks=log:1:20:6  mass_ratio=log:1e-06:1e+06:9
    Stack of unlike masses
    The mass of the top box relative to that of the lowest.

stack_jitter  stack[push=1.0]  blocks=log:1:20:6  jitter=zero:1e-12:0.01:7
    Stack of nearly equal boxes
    From exact ties, at 0, over near ties to none.

pyramid  pyramid[push=1.0]  rows=log:1:9:6  friction=0.05:1.1:8
    Pyramid, the topmost box pushed
    Every box rests on two.

wall  wall[push=1.0,columns=4]  rows=log:1:7:6  friction=0.05:1.1:8
    Brick wall, the lowest left brick pushed
    Bricks flush on all sides: every contact is a tie, and there are more contacts than degrees of freedom.

arch  arch[push=0.1]  stones=log:3:25:6  friction=0.05:1.1:8
    Arch, its middle stone pushed
    Interlocking stones.

sheared_stack  stack[blocks=15,push=0.0]  shear=log:0.001:100:6  friction=0.05:1.1:8
    Sheared stack of 15 boxes
    Velocity grows with height.

pushed_pyramid  pyramid[rows=7,push=1.0]  shear=log:0.001:100:6  friction=0.05:1.1:8
    Sheared pyramid of seven rows, its top pushed
    Interior point methods may stall here, and path-following methods meet folds of the path.
"""
_UNITS = f"""
units_stack  stack[blocks=5,push=1.0]  mass_unit={UNIT}  length_unit={UNIT}
    Units of mass and length: five boxes

units_painleve_rod  painleve_rod[angle={math.atan(2.0)!r}]  mass_unit={UNIT}  length_unit={UNIT}
    Units of mass and length: rod

units_pyramid  pyramid[rows=4,push=1.0]  mass_unit={UNIT}  length_unit={UNIT}
    Units of mass and length: pyramid
"""
_LOOPS = """
steps_bowl  bowl  step=log:1e-4:1:5  friction=0:0.9:4
    Step size in closed loop: bead in a bowl

steps_stack  stack[blocks=3,push=1.0]  step=log:1e-4:1:5  friction=0.05:0.95:4
    Step size in closed loop: three boxes, the lowest pushed

steps_painleve_rod  painleve_rod  step=log:1e-4:1:5  friction=0.4:2.5:4
    Step size in closed loop: rod
"""


def atlas() -> tuple[Map, ...]:
    """Return all maps of the suite."""
    same = "The same problem in other units, powers of two from 1e-12 to 1e12: not even rounding differs, nothing may change."
    loops = _maps(_LOOPS, "At most 30 steps of each size.", scheme=GAP_SCHEME, steps=30, refined=False)
    return (*_maps(_MAPS), *_maps(_UNITS, same, constant=True), *loops)


def _maps(table: str, common_note: str = "", **common: Any) -> tuple[Map, ...]:
    """Parse the maps in a table. common: fields shared by all."""
    maps = []
    for block in table.strip().split("\n\n"):
        head, title, *note = map(str.strip, block.splitlines())
        name, spec, x, y, *more = head.split()
        scene, parameters = parse("scene", spec)
        schemes: Any = dict(each.split("=") for each in more if "=" in each)
        thresholds = tuple(each for each in more if "=" not in each)
        axes = axis("x", x, scene), axis("y", y, scene)
        text = " ".join(note) or common_note
        maps.append(Map(name, scene, *axes, parameters, thresholds=thresholds, title=title, note=text, **schemes | common))
    return tuple(maps)


def axis(field: str, text: str, name: str) -> Axis:
    """Parse the axis of a scene's parameter. Errors: InputError naming the field."""
    parameter, _, values = text.partition("=")
    *scale, first, last, number = values.split(":") if values.count(":") in (2, 3) else ("", "", "", "", "")
    kind: Any = scale[0] if scale else "linear"
    try:
        low, high, count = float(first), float(last), int(number)
    except ValueError:
        raise InputError(f"{field}: cannot read {text!r}; write PARAMETER=FROM:TO:N or PARAMETER=log:FROM:TO:N") from None
    require(kind in SCALES, field, f"unknown scale {kind!r}; known are {', '.join(SCALES)}")
    require(kind == "linear" or 0 < low < high, field, f"{text!r} needs 0 < FROM < TO")
    many = 0 < high - low < math.inf and 2 <= count <= MOST_LINES
    require(many, field, f"{text!r} needs FROM < TO and 2 to {MOST_LINES} values")
    require(kind != "both" or count % 2 == 1, field, f"{text!r} needs an odd number of values, one of them 0")
    parameter = parameter.strip()
    whole = name in scenes() and isinstance(scenes()[name].parameters.get(parameter), int)
    return Axis(parameter, low, high, count, kind, whole)
