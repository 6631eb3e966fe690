"""A house of cards, which stands by friction alone: every leaning card thrusts outwards."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array
from frictionbench.problems.parameters import count, number
from frictionbench.problems.planar.bodies import Body, half_plane, homogeneous, rigid_box
from frictionbench.problems.scene import Scene

THICK, HIGH, TOP = 0.1, 1.0, 0.15  # m: of a card along the ground, of a pair, and of the level top of each of its cards


@generator()
def house_of_cards(
    storeys: int = 2, friction: float = 0.5, lean: float = 0.3, push: float = 0.0, step: float = 0.01, duration: float = 1.0
) -> Scene:
    """Pairs of cards that lean against each other, on the ground and on level cards that bridge the pairs below.

    A card's ends are cut level at its foot and upright and level at its head, so that edges meet edges. A pair alone stands iff
    friction >= about lean/2 at its feet. The lowest storey has as many pairs as there are storeys, each further one a pair
    fewer. lean: the distance of a foot from the middle of its pair, m, for a height of 1 m. push: m/s, of the topmost pair, to
    the right.
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
        friction=friction,
        step=step,
        duration=duration,
    )
