"""Structures on the ground: an arch, a house of cards, a table on many legs.

The arch stands because of its thrust and the friction of its joints. The house of cards stands because of friction alone, as
every leaning card thrusts outwards.
"""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array, count, number
from frictionbench.problems.planar.bodies import Body, Shape, box, half_plane, homogeneous, rigid_box
from frictionbench.problems.scene import Scene

THICK, HIGH, TOP = 0.1, 1.0, 0.15  # m: a card's thickness along the ground, a pair's height, the width of a card's level top


@generator(friction=0.5, duration=1.0)
def arch(stones: int = 7, thickness: float = 0.3, push: float = 0.0) -> Scene:
    """A semicircular arch of equal stones on the ground.

    It stands iff it is thick enough for a line of thrust (for many stones thickness >= 0.107, Heyman 1969) and no joint
    slides. Its centre line has a radius of 1 m. thickness: m. push: m/s, of the middle stone, to the right.
    """
    n, thick = count("stones", stones, least=2), number("thickness", thickness, above=0, most=1)
    half = np.pi / n / 2
    inner, outer = 1 - thick / 2, 1 + thick / 2
    corners = np.array([[outer, -half], [outer, half], [inner, half], [inner, -half]])
    stone = corners[:, :1] * np.column_stack([np.cos(corners[:, 1]), np.sin(corners[:, 1])])
    body, centre = homogeneous(stone)
    bodies = (body,) * n
    turn = np.pi - half * (2 * np.arange(n) + 1)
    velocity = np.zeros((n, 3))
    velocity[n // 2, 0] = number("push", push)
    return Scene(
        bodies=bodies,
        obstacles=(half_plane(),),
        q0=np.column_stack([centre[0] * np.cos(turn), centre[0] * np.sin(turn), turn]),
        v0=velocity,
    )


@generator(friction=0.5, duration=1.0)
def house_of_cards(storeys: int = 2, lean: float = 0.3, push: float = 0.0) -> Scene:
    """Pairs of cards that lean against each other, on the ground and on level cards that bridge the pairs below.

    A card is cut level at its foot, and vertically and level at its head, so that edges meet edges. A single pair stands iff
    the friction at its feet is at least about lean/2. The lowest storey has as many pairs as there are storeys, each further
    storey one pair fewer. lean: the distance of a foot from the middle of its pair, m, for a height of 1 m. push: m/s, of the
    topmost pair, to the right.
    """
    storeys, lean = count("storeys", storeys), number("lean", lean, least=0.1, most=1)
    apart = 2 * (lean + THICK) + 0.1  # between the middles of neighbouring pairs
    left = np.array([[-lean - THICK, 0.0], [-lean, 0.0], [0.0, HIGH - 0.2], [0.0, HIGH], [-TOP, HIGH]])
    left_card, left_centre = homogeneous(left)
    right_card, right_centre = homogeneous((left * [-1, 1])[::-1])
    bodies: list[Body] = []
    place: list[Array] = []
    for storey in range(storeys):
        middle = apart * (np.arange(storeys - storey) + storey / 2)
        height = storey * (HIGH + THICK)
        for x in middle:
            bodies += [left_card, right_card]
            place += [centre + np.array([x, height]) for centre in (left_centre, right_centre)]
        for x in (middle[:-1] + middle[1:]) / 2:
            bodies.append(rigid_box(apart - 0.1, THICK))
            place.append(np.array([x, height + HIGH + THICK / 2]))
    velocity = np.zeros((len(bodies), 3))
    velocity[-2:, 0] = number("push", push)
    return Scene(
        bodies=tuple(bodies),
        obstacles=(half_plane(),),
        q0=np.column_stack([np.array(place), np.zeros(len(place))]),
        v0=velocity,
    )


@generator(friction=0.5, duration=1.0)
def redundant_table(legs: int = 4, speed: float = 1.0) -> Scene:
    """A table on a row of legs: the distribution of its weight over the legs is not determined.

    Only the resultant m g h, its moment about the middle and the velocity are determined. While the table slides, friction
    mu m g decelerates it. The top is 4 by 0.2, with its middle 1 m above the ground; the legs have no mass. speed: m/s, to the
    right; with 0 the table rests, and friction does not act.
    """
    feet = np.linspace(-1.5, 1.5, count("legs", legs, least=2))
    mass = 4.0 * 0.2
    shapes = (box(4.0, 0.2), *(Shape(np.array([[x, -1.0], [x, 0.0]])) for x in feet))
    return Scene(
        bodies=(Body(mass, mass * (4.0**2 + 0.2**2) / 12, shapes),),
        obstacles=(half_plane(),),
        q0=np.array([0.0, 1.0, 0.0]),
        v0=np.array([number("speed", speed), 0.0, 0.0]),
    )
