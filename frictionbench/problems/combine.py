"""Larger problems from smaller ones."""

import numpy as np
from scipy import sparse

from frictionbench.problems.friction import FrictionProblem


def side_by_side(*problems: FrictionProblem) -> FrictionProblem:
    """Problems of one dimension as one, without any coupling."""
    matrices = {
        name: sparse.block_diag([getattr(problem, name) for problem in problems], format="csr")
        for name in ("mass", "normal", "tangent", "joints")
    }
    names = ("friction", "free_velocity", "bias", "friction_bias", "joint_bias")
    vectors = {name: np.concatenate([getattr(problem, name) for problem in problems]) for name in names}
    return FrictionProblem(**matrices, **vectors, dimension=problems[0].dimension)
