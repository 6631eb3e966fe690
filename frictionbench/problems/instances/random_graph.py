"""Random planar contact graphs without places: any two bodies may touch, so that no order of elimination is sparse."""

import numpy as np
from scipy import sparse

from frictionbench.problems.catalogue import instance
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.local_graph import FRICTION, INERTIA, PAIRS, graph_rows
from frictionbench.problems.parameters import count


@instance
def random_graph(seed: int = 0, bodies: int = 100) -> FrictionProblem:
    """Planar bodies touching any others, near or not, at random points and normals: a contact graph with much fill.

    1.6 contacts a body, the arms of each from both centres normal with standard deviation .5 m; masses, friction and free
    velocities as in local_graph.
    """
    nb = count("bodies", bodies, least=8)
    random = np.random.default_rng([count("seed", seed, least=0), nb])
    nc = int(PAIRS * nb)
    first = random.integers(nb, size=nc)
    pair = np.column_stack([first, (first + random.integers(1, nb, size=nc)) % nb])
    arm = 0.5 * random.standard_normal((nc, 2)), 0.5 * random.standard_normal((nc, 2))
    angle = random.uniform(0, 2 * np.pi, nc)
    least, most = FRICTION
    return FrictionProblem(
        mass=sparse.diags_array(np.tile([1.0, 1.0, INERTIA], nb)),
        normal=graph_rows(pair, arm, np.column_stack([np.cos(angle), np.sin(angle)]), nb),
        tangent=graph_rows(pair, arm, np.column_stack([-np.sin(angle), np.cos(angle)]), nb),
        friction=least * (most / least) ** random.random(nc),
        free_velocity=random.standard_normal(3 * nb),
        bias=np.zeros(nc),
    )
