"""A wall of boxes in space with several contacts per face: hyperstatic, hundreds of contacts on few bodies."""

from collections.abc import Iterator

import numpy as np

from frictionbench.problems.catalogue import instance
from frictionbench.problems.check import Array, count, number, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import GROUND, falling, touching
from frictionbench.problems.spatial.rotation import frames

HALF_EDGES = np.array([0.5, 0.25, 0.25])  # m, half the edges of a brick of 1 kg
CORNERS = ((-1, -1), (-1, 1), (1, -1), (1, 1))
MIDDLES = ((-1, 0), (1, 0), (0, -1), (0, 1))  # of the edges
Bricks = dict[tuple[int, int], int]  # (row, position in the row): body
Contact = tuple[tuple[int, int], Array, tuple[int, int, int]]  # bodies, the point from the centre of the first, the normal


@instance()
def box_wall(
    seed: int = 0,
    rows: int = 4,
    bricks: int = 4,
    points: int = 4,
    friction: float = 1.0,
    noise: float = 0.1,
    push: float = 0.1,
    step: float = 0.01,
) -> FrictionProblem:
    """A wall of boxes in space, pushed along its length; every second row is offset by half a brick and one brick shorter.

    points: contacts per horizontal face: 4 at the corners, or 8 with the midpoints of the edges; vertical faces have 4. Normals
    are perturbed at random by 1e-3. noise: m/s and rad/s, standard deviation of every velocity, added to gravity. push: m/s.
    """
    rows, bricks, points = count("rows", rows), count("bricks", bricks, least=2), count("points", points)
    require(points in {4, 8}, "points", f"expected 4 or 8, got {points!r}")
    random = np.random.default_rng([count("seed", seed, least=0), rows, bricks, points])
    place = [(k, j) for k in range(rows) for j in range(bricks - k % 2)]
    centre = np.array([(j + k % 2 / 2, 0.0, (2 * k + 1) * HALF_EDGES[2]) for k, j in place])
    contacts = list(_contacts({at: a for a, at in enumerate(place)}, CORNERS if points == 4 else CORNERS + MIDDLES))
    bodies = np.array([pair for pair, _, _ in contacts])
    point = centre[bodies[:, 0]] + np.array([arm for _, arm, _ in contacts])
    normal = np.array([along for _, _, along in contacts]) + 1e-3 * random.standard_normal((len(contacts), 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    velocity = number("noise", noise, least=0) * random.standard_normal((len(centre), 6))
    velocity += falling(len(centre), number("step", step, above=0))
    velocity[:, 0] += number("push", push)
    square = (2 * HALF_EDGES) ** 2
    return touching(
        bodies,
        np.stack([point - centre[bodies[:, 0]], point - centre[bodies[:, 1]]], axis=1),
        frames(normal),
        np.tile(np.append(np.ones(3), (square.sum() - square) / 12), (len(centre), 1)),
        velocity,
        number("friction", friction, least=0),
    )


def _contacts(bricks: Bricks, face: tuple[tuple[int, int], ...]) -> Iterator[Contact]:
    """All contacts of the wall. face: the contact points of a horizontal face, in units of half its edges."""
    for (k, j), a in bricks.items():
        if k == 0:
            halves = [(GROUND, 0.0, 1.0)]  # the body below, the middle of the common face, half its length
        else:  # odd rows start half a brick further to the right than even rows
            below = {-0.5: (k - 1, j - 1 + k % 2), 0.5: (k - 1, j + k % 2)}
            halves = [(bricks[at], side, 0.5) for side, at in below.items() if at in bricks]
        for b, middle, reach in halves:
            for x, y in face:
                yield (a, b), HALF_EDGES * (middle + reach * x, y, -1), (0, 0, 1)
        if j > 0:
            for y, z in CORNERS:
                yield (a, bricks[k, j - 1]), HALF_EDGES * (-1, y, z), (1, 0, 0)
