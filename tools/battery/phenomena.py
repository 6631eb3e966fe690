"""The phenomena: the bodies, the quantity measured after some time, and its closed form.

Each is a problem of rigid bodies with Coulomb friction in SI units. An engine's result differs because of its model and step.
"""

from collections.abc import Callable, Iterator
from functools import partial
from time import process_time
from typing import NamedTuple

import numpy as np

from tools.battery.world import GRAVITY, Array, Body, Make, Setting

CUBE, SETTLED = (0.1, 0.1, 0.1), 0.5  # half sizes, m; time until a body at rest has settled, s
PHASES = np.arange(8) / 8  # fractions of a step by which a fall or a slide begins later
GROOVE = GRAVITY * (0.5 - 0.2 * np.sqrt(1.5)) / 2  # distance down the groove in one second, m
TILTING = 0.6  # s: 8 ms between two slopes, a multiple of every step in the table


class Phenomenon(NamedTuple):
    """exact: the value of the closed form in `unit`. formula: the closed form as text, empty if a time is measured.
    measure: the function of engine and step that returns the number, or one for each of PHASES if it depends on when within a
    step bodies meet or stop."""

    name: str
    formula: str
    exact: float
    unit: str
    measure: Callable[[Make, float], float | list[float]]


def creep(make: Make, step: float) -> float:
    """The speed of a box on a slope of 20 degrees whose friction of 0.5 holds it, over a second after it has settled."""
    world = make(Setting((Body(CUBE, 1.0, (0, 0, 0.1)),), 0.5, slope=np.radians(20)), step)
    world.run(SETTLED)
    before = world.position(0).copy()
    world.run(1.0)
    return float(np.linalg.norm(world.position(0) - before))


def stopping(make: Make, step: float) -> list[float]:
    """The way of a box that slides at 2 m/s on friction 0.5 until it rests."""
    return [float(way[0] + (2.0**2 - speed**2) / GRAVITY) for speed, way in _slides(make, step, 0.0)]


def direction(make: Make, step: float) -> list[float]:
    """The direction, in degrees, in which a box thrown at 30 degrees to its sides has moved when it has lost its speed."""
    return [float(np.degrees(np.arctan2(way[1], way[0]))) for _, way in _slides(make, step, np.radians(30))]


def _slides(make: Make, step: float, angle: float) -> Iterator[tuple[float, Array]]:
    """Yield for each of PHASES the speed left of 2 m/s by friction 0.5, and the displacement (3,) of a box thrown so, m."""
    for speed in 2.0 - 0.5 * GRAVITY * step * PHASES:
        velocity = speed * np.array([np.cos(angle), np.sin(angle), 0.0])
        world = make(Setting((Body(CUBE, 1.0, (0, 0, 0.1), velocity),), 0.5), step)
        world.run(1.0)
        yield speed, world.position(0)


def heavy_on_light(make: Make, step: float) -> float:
    """How far a box of 1000 kg sinks that stands on one of 1 kg, a second after they were put down."""
    world = make(Setting((Body(CUBE, 1.0, (0, 0, 0.1)), Body(CUBE, 1000.0, (0, 0, 0.3))), 0.5), step)
    world.run(1.0)
    return float(0.3 - world.position(1)[2])


def rebound(make: Make, step: float, restitution: float = 0.0) -> list[float]:
    """The speed upwards after a ball with restitution e has fallen 0.2 m, the largest in the time that follows. MuJoCo has no
    e: its rows show the stiffness and damping that we chose."""
    found = []
    for phase in PHASES:
        begun = GRAVITY * phase * step  # initial speed of the ball, which starts later on the same trajectory
        ball = Body((0.1,), 1.0, (0, 0, 0.3 - begun**2 / (2 * GRAVITY)), (0, 0, -begun))
        world = make(Setting((ball,), 0.5, restitution=restitution), step)
        world.run(np.sqrt(0.4 / GRAVITY) - 0.01)
        most = 0.0
        for _ in range(round(0.1 / step)):
            world.run(step)
            most = max(most, float(world.velocity(0)[2]))
        found.append(most)
    return found


def rolling(make: Make, step: float) -> list[float]:
    """The speed of a ball that was thrown at 2 m/s without spin on friction 0.3, when it rolls."""
    found = []
    for speed in 2.0 - 0.3 * GRAVITY * step * PHASES:
        world = make(Setting((Body((0.1,), 1.0, (0, 0, 0.1), (speed, 0, 0)),), 0.3), step)
        world.run(0.4)
        found.append(float(world.velocity(0)[0] + 5 / 7 * (2.0 - speed)))
    return found


def stack(make: Make, step: float) -> float:
    """How far the highest of five boxes on each other has moved in two seconds."""
    world = make(Setting(tuple(Body(CUBE, 1.0, (0, 0, 0.1 + 0.2 * k)) for k in range(5)), 0.5), step)
    world.run(2.0)
    return float(np.linalg.norm(world.position(4) - [0, 0, 0.9]))


def cost(make: Make, step: float) -> float:
    """The processor time of a second of the stack of five, the smallest of three, by the engine's Python interface."""
    bodies = tuple(Body(CUBE, 1.0, (0, 0, 0.1 + 0.2 * k)) for k in range(5))
    times = []
    for _ in range(3):
        world = make(Setting(bodies, 0.5), step)
        world.run(0.1)
        began = process_time()
        world.run(1.0)
        times.append(process_time() - began)
    return 1000 * min(times)


def wedge(make: Make, step: float) -> list[float]:
    """The way of a box that slides on its edge in a right-angled groove, inclined by 30 degrees, friction 0.2, in a second."""
    quarter, found = np.pi / 4, []
    for speed in 2 * GROOVE * step * PHASES:  # initial speed of the box, which starts later on the same slide
        box = Body(CUBE, 1.0, (0, 0, 0.1 * np.sqrt(2)), (speed, 0, 0), turn=quarter)
        world = make(Setting((box,), 0.2, slope=np.radians(30), floors=(quarter, -quarter)), step)
        world.run(1.0)
        found.append(float(world.position(0)[0] - speed))
    return found


def tipping(make: Make, step: float) -> float:
    """The tangent of the slope at which a box of 0.1 x 0.1 x 0.4 m tips over, bisected to 0.001: it settles on level ground,
    which is then tilted in 0.6 s."""
    low, high = 0.15, 0.35
    while high - low > 1e-3:
        middle = (low + high) / 2
        world = make(Setting((Body((0.05, 0.05, 0.2), 1.0, (0, 0, 0.2)),), 1.0), step)
        world.run(0.2)
        for share in np.linspace(0, 1, 76)[1:]:
            world.tilt(float(share * np.arctan(middle)))
            world.run(TILTING / 75)
        world.run(1.5)
        low, high = (low, middle) if world.position(0)[2] < 0.15 else (middle, high)  # tipped, or not
    return (low + high) / 2


PHENOMENA = (
    Phenomenon("creep on a slope", "0, as tan 20° < mu", 0.0, "m/s", creep),
    Phenomenon("stopping distance", "v²/(2 mu g)", 2.0 / GRAVITY / 0.5, "m", stopping),
    Phenomenon("direction of sliding", "that of the throw", 30.0, "°", direction),
    Phenomenon("1000 kg on 1 kg, sinking", "0", 0.0, "m", heavy_on_light),
    Phenomenon("rebound, e = 0", "0", 0.0, "m/s", rebound),
    Phenomenon("rebound, e = 0.5", "e √(2 g H)", 0.5 * np.sqrt(0.4 * GRAVITY), "m/s", partial(rebound, restitution=0.5)),
    Phenomenon("rebound, e = 1", "√(2 g H)", np.sqrt(0.4 * GRAVITY), "m/s", partial(rebound, restitution=1.0)),
    Phenomenon("sliding ball that rolls", "5/7 v", 10 / 7, "m/s", rolling),
    Phenomenon("stack of five at rest", "0", 0.0, "m", stack),
    Phenomenon("box in a groove", "g (sin a - √2 mu cos a) t²/2", GROOVE, "m", wedge),
    Phenomenon("tipping, tan of the slope", "width/height", 0.25, "", tipping),
    Phenomenon("cost of a simulated second", "", 0.0, "ms", cost),
)
