"""Changes of a problem under which its velocities stay the same or are multiplied by a known factor."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array


def with_friction(problem: FrictionProblem, friction: Array) -> FrictionProblem:
    return problem.replace(friction=friction)


def permuted(problem: FrictionProblem, order: NDArray[np.intp]) -> FrictionProblem:
    """The contacts in another order, which may repeat contacts."""
    rows = (order[:, None] * (problem.dimension - 1) + np.arange(problem.dimension - 1)).ravel()
    by_contact = {name: getattr(problem, name)[order] for name in ("friction", "bias", "friction_bias")}
    return problem.replace(normal=problem.normal[order], tangent=problem.tangent[rows], **by_contact)


def duplicated(problem: FrictionProblem) -> FrictionProblem:
    """Every contact twice."""
    return permuted(problem, np.repeat(np.arange(problem.contacts), 2))


def mirrored(problem: FrictionProblem) -> FrictionProblem:
    """The first tangent of every contact reversed."""
    sign = np.where(np.arange(problem.tangent.shape[0]) % (problem.dimension - 1) == 0, -1.0, 1.0)
    return problem.replace(tangent=sparse.diags_array(sign) @ problem.tangent)


def rotated(problem: FrictionProblem, angle: Array) -> FrictionProblem:
    """The tangents of contact i of a spatial problem rotated by angle[i]."""
    turns = [[[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]] for a in angle]
    return problem.replace(tangent=sparse.block_diag(turns, format="csr") @ problem.tangent)


def in_units(problem: FrictionProblem, mass: float, velocity: float) -> FrictionProblem:
    """In units in which the values of masses are `mass` and those of velocities `velocity` times as large."""
    return problem.replace(
        mass=mass * problem.mass,
        free_velocity=velocity * problem.free_velocity,
        bias=velocity * problem.bias,
        friction_bias=mass * velocity * problem.friction_bias,
        joint_bias=velocity * problem.joint_bias,
    )
