"""Small problems that several tests share."""

import numpy as np
from scipy import sparse

from problems import FrictionProblem


def block(speed=1.0, friction=0.5, mass=2.0, h=0.01, **more) -> FrictionProblem:
    """A point mass on the ground under gravity, sliding at `speed`."""
    return FrictionProblem(
        mass=mass * np.eye(2),
        normal=[[0.0, 1.0]],
        tangent=[[1.0, 0.0]],
        friction=[friction],
        free_velocity=[speed, -9.81 * h],
        bias=[0.0],
        **more,
    )


def nothing(dimension=2) -> FrictionProblem:
    """No contact at all."""
    return FrictionProblem(
        mass=np.eye(3),
        normal=np.zeros((0, 3)),
        tangent=np.zeros((0, 3)),
        friction=[],
        free_velocity=[1.0, 2.0, 3.0],
        bias=[],
        dimension=dimension,
    )


def spatial(seed, contacts=5, nv=18, friction=None, friction_bias=False, joints=0) -> FrictionProblem:
    """Random spatial contacts on nv velocities, with a few joints and friction biases if asked for."""
    random = np.random.default_rng(seed)
    rows = random.standard_normal((3 * contacts, nv)) * (random.random((3 * contacts, nv)) < 0.5)
    each = np.arange(3 * contacts).reshape(contacts, 3)
    return FrictionProblem(
        mass=np.diag(10 ** random.random(nv)),
        normal=rows[each[:, 0]],
        tangent=rows[each[:, 1:].ravel()],
        friction=np.full(contacts, random.uniform(0.05, 1) if friction is None else friction),
        free_velocity=random.standard_normal(nv),
        bias=np.zeros(contacts),
        friction_bias=0.3 * random.random(contacts) if friction_bias else None,
        joints=random.standard_normal((joints, nv)),
        dimension=3,
    )


def with_joints(problem, joints, friction_bias=None) -> FrictionProblem:
    """A problem with joints F v = 0 and a friction bias added."""
    names = ("mass", "normal", "tangent", "friction", "free_velocity", "bias", "dimension")
    return FrictionProblem(**{name: getattr(problem, name) for name in names}, joints=joints, friction_bias=friction_bias)


def spatial_stack(boxes, friction=0.5, push=0.0, heavy_top=1.0, h=0.01) -> FrictionProblem:
    """Unit cubes upon each other, touching at their four corners: hyperstatic, with exact ties.

    push: m/s, askew, and the faster the higher. heavy_top: the mass of the top one over that of the bottom one.
    """
    rows, columns, values = [], [], []
    corners = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    for box in range(boxes):
        for corner, (x, y) in enumerate(corners):
            for body, sign, z in ((box, 1, -0.5), (box - 1, -1, 0.5)):
                if body < 0:
                    continue
                arms = ([0, 0, 1, y, -x, 0], [1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x])  # normal, two tangents: e and r x e
                rows += np.repeat(3 * (4 * box + corner) + np.arange(3), 6).tolist()
                columns += (6 * body + np.tile(np.arange(6), 3)).tolist()
                values += (sign * np.ravel(arms)).tolist()
    jacobian = sparse.csr_array((values, (rows, columns)), shape=(12 * boxes, 6 * boxes))
    jacobian.eliminate_zeros()
    each = np.arange(12 * boxes).reshape(-1, 3)
    mass = np.geomspace(1, heavy_top, boxes) if boxes > 1 else np.ones(1)
    v = np.zeros((boxes, 6))
    v[:, 2] = -9.81 * h
    v[:, :2] = push * np.outer(np.arange(1, boxes + 1) / boxes, [0.8, 0.6])
    return FrictionProblem(
        mass=sparse.diags_array(np.outer(mass, [1, 1, 1, 1 / 6, 1 / 6, 1 / 6]).ravel()),
        normal=jacobian[each[:, 0]],
        tangent=jacobian[each[:, 1:].ravel()],
        friction=np.full(4 * boxes, friction),
        free_velocity=v.ravel(),
        bias=np.zeros(4 * boxes),
        dimension=3,
    )


def spatial_bodies(seed, contacts, friction=0.5) -> FrictionProblem:
    """Contacts in random directions between random pairs of bodies, one body for two contacts: sparse, as scenes are."""
    random = np.random.default_rng(seed)
    bodies = max(2, contacts // 2)
    jacobian = np.zeros((contacts, 3, bodies, 6))
    for i in range(contacts):
        frame = np.linalg.qr(random.standard_normal((3, 3)))[0]
        for body, sign in zip(random.choice(bodies, 2, replace=False), (1, -1), strict=True):
            arm = random.uniform(-0.5, 0.5, 3)
            jacobian[i, :, body, :3], jacobian[i, :, body, 3:] = sign * frame, sign * np.cross(arm, frame)
    rows = jacobian.reshape(contacts, 3, 6 * bodies)
    return FrictionProblem(
        mass=np.diag(np.outer(10 ** random.random(bodies), [1, 1, 1, 1 / 6, 1 / 6, 1 / 6]).ravel()),
        normal=rows[:, 0],
        tangent=rows[:, 1:].reshape(2 * contacts, -1),
        friction=np.full(contacts, friction),
        free_velocity=random.standard_normal(6 * bodies),
        bias=np.zeros(contacts),
        dimension=3,
    )


def sphere_pyramid(seed, levels, friction, noise=0.0, h=0.01) -> FrictionProblem:
    """A square pyramid of unit spheres, each touching its neighbours of the layer and four below: hyperstatic.

    The normals between spheres are askew by 1e-3, at random. noise: m/s on every freedom, beside gravity.
    """
    random = np.random.default_rng([seed, levels])
    centre = np.array(
        [(i + k / 2, j + k / 2, k / np.sqrt(2)) for k in range(levels) for i in range(levels - k) for j in range(levels - k)]
    )
    bodies = len(centre)
    pairs = [(a, -1) for a in range(levels**2)]
    pairs += [(a, b) for a in range(bodies) for b in range(a) if np.linalg.norm(centre[a] - centre[b]) < 1.01]
    jacobian = np.zeros((len(pairs), 3, bodies, 6))
    for i, (a, b) in enumerate(pairs):
        between = np.array([0.0, 0.0, 1.0]) if b < 0 else centre[a] - centre[b]
        normal = between + (1e-3 * random.standard_normal(3) if b >= 0 else 0)
        frame = np.linalg.qr(np.column_stack([normal, random.standard_normal((3, 2))]))[0].T
        frame[0] = normal / np.linalg.norm(normal)
        for body, sign in ((a, 1), (b, -1)):
            if body >= 0:
                jacobian[i, :, body, :3], jacobian[i, :, body, 3:] = sign * frame, np.cross(-between / 2, frame)
    rows = sparse.csr_array(jacobian.reshape(3 * len(pairs), 6 * bodies))
    each = np.arange(3 * len(pairs)).reshape(-1, 3)
    v = noise * random.standard_normal((bodies, 6))
    v[:, 2] -= 9.81 * h
    return FrictionProblem(
        mass=sparse.diags_array(np.tile([1, 1, 1, 0.1, 0.1, 0.1], bodies)),
        normal=rows[each[:, 0]],
        tangent=rows[each[:, 1:].ravel()],
        friction=np.full(len(pairs), friction),
        free_velocity=v.ravel(),
        bias=np.zeros(len(pairs)),
        dimension=3,
    )
