"""A chain of rods with ball joints on the ground: contacts and joints together, in space."""

import numpy as np
from scipy import sparse

from frictionbench.problems.catalogue import instance
from frictionbench.problems.check import count, number
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import GROUND, falling, touching
from frictionbench.problems.spatial.rotation import frames


@instance()
def rod_chain(
    seed: int = 0,
    links: int = 5,
    friction: float = 0.5,
    pull: float = 1.0,
    whirl: float = 1.0,
    fall: float = 0.0,
    mass_ratio: float = 1.0,
    step: float = 0.01,
) -> FrictionProblem:
    """Rods 1 m long lie on the ground in a random zigzag, joined end to end by ball joints, and are dragged along.

    Each rod touches the ground with two feet, 0.2 m from its ends and 0.05 m below its axis. pull: m/s, of all rods, in one
    direction. whirl: rad/s, standard deviation of the rods' free spins about the vertical, before the joints act. fall: m/s,
    downwards. mass_ratio: the mass of the last rod divided by that of the first, geometric in between.
    """
    n = count("links", links)
    random = np.random.default_rng([count("seed", seed, least=0), n])
    heading = np.cumsum(random.uniform(-1.2, 1.2, n))
    along = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(n)])
    below = np.array([0.0, 0.0, -0.05])
    rod = np.repeat(np.arange(n), 2)
    feet = np.where(np.arange(2 * n) % 2, 0.3, -0.3)[:, None] * along[rod] + below
    mass = number("mass_ratio", mass_ratio, above=0) ** (np.arange(n) / max(n - 1, 1))
    velocity = falling(n, number("step", step, above=0))
    velocity[:, 0] += number("pull", pull)
    velocity[:, 2] -= number("fall", fall)
    velocity[:, 5] = number("whirl", whirl, least=0) * random.standard_normal(n)
    return touching(
        np.column_stack([rod, np.full(2 * n, GROUND)]),
        np.stack([feet, np.zeros((2 * n, 3))], axis=1),
        frames(np.tile([0.0, 0.0, 1.0], (2 * n, 1))),
        np.outer(mass, [1, 1, 1, 1 / 12, 1 / 12, 1 / 12]),
        velocity,
        number("friction", friction, least=0),
        joints=_ball_joints(along),
    )


def _ball_joints(along: np.ndarray) -> sparse.csr_array:
    """F (3 (n-1), 6 n): the end of each rod moves with the start of the next, v_a + w_a x e_a/2 = v_b - w_b x e_b/2."""
    n = len(along)
    F = sparse.lil_array((3 * (n - 1), 6 * n))
    for i in range(n - 1):
        for rod, sign in ((i, 1.0), (i + 1, -1.0)):
            x, y, z = sign * along[rod] / 2  # from the rod's centre to the joint
            F[3 * i : 3 * i + 3, 6 * rod : 6 * rod + 3] = sign * np.eye(3)
            F[3 * i : 3 * i + 3, 6 * rod + 3 : 6 * rod + 6] = sign * np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
    return sparse.csr_array(F)
